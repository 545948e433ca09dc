#include "mien/synthetic/eyewear/worn_glasses.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/virtual/eyewear/eyewear_faults.h"
#include "mien/virtual/eyewear/eyewear_wearer.h"
#include "tests/project_path.h"

namespace mien::synthetic::worn_glasses_test {
namespace {

class WornGlassesTest : public testing::Test {
 protected:
  sensor::Rig rig_ = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
  virt::EyewearFaults faults_ = virt::parse_eyewear_faults(rig_.faults_toml, "rig").value();
  virt::EyewearWearer wearer_ = virt::draw_eyewear_wearer(rig_, faults_, Random(5)).value();
  virt::EyewearSimulator simulator_{wearer_, faults_, Random(6)};
  WornGlasses session_{simulator_, rig_};
};

TEST_F(WornGlassesTest, ShowsEveryFrameOfTheGridOnce) {
  std::size_t frames = 0, there = 0;
  const auto see = [&](const eyewear::GridLight& light, const face::BlendshapeWeights&) {
    ++frames;
    for (const std::uint8_t present : light.present) there += present;
  };
  const face::Motion motion = range_of_motion(Random(1));
  session_.play(motion, 2, see);
  session_.rest(3);
  session_.play(motion, 1.5, see);
  EXPECT_EQ(frames, 210u);
  EXPECT_GT(there, 20 * 200u) << "all but the first frames of all sensors";
  EXPECT_DOUBLE_EQ(session_.now_s(), 6.5);
}

TEST_F(WornGlassesTest, AMinuteGivesEverySensorNeutralAndRange) {
  std::size_t frames = 0;
  const eyewear::Normalisation made = session_.first_minute(
      Random(2), [&](const eyewear::GridLight&, const face::BlendshapeWeights&) { ++frames; });
  EXPECT_EQ(frames, 3600u);
  EXPECT_TRUE(made.complete);
  ASSERT_EQ(made.sensors.size(), rig_.sensors.size());
  for (const eyewear::SensorNormalisation& sensor : made.sensors) {
    EXPECT_TRUE(sensor.valid) << sensor.sensor;
    EXPECT_GT(sensor.moved, 0) << sensor.sensor;
  }
  const eyewear::Normalisation held = session_.hold_neutral(made, Random(3));
  for (std::size_t s = 0; s < made.sensors.size(); ++s) {
    EXPECT_EQ(held.sensors[s].range, made.sensors[s].range);
    EXPECT_NE(held.sensors[s].neutral, made.sensors[s].neutral);
  }
}

TEST(RangeOfMotion, GoesFarAndBack) {
  const face::Motion motion = range_of_motion(Random(4));
  EXPECT_GE(motion.frames.size(), static_cast<std::size_t>(kRangeS * 60));
  float jaw = 0, brow = 0;
  for (const face::MotionFrame& frame : motion.frames) {
    jaw = std::max(jaw, frame.weights[face::shape("jawOpen")]);
    brow = std::max(brow, frame.weights[face::shape("browInnerUp_L")]);
  }
  EXPECT_GT(jaw, 0.5F);
  EXPECT_GT(brow, 0.5F);
  EXPECT_LT(motion.frames.back().weights[face::shape("jawOpen")], 0.05F);
}

}  // namespace
}  // namespace mien::synthetic::worn_glasses_test
