#include "mien/face/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "mien/core/random.h"
#include "mien/face/livelink_csv.h"
#include "tests/project_path.h"

namespace mien::face::motion_test {
namespace {

constexpr std::size_t kJaw = shape("jawOpen");

Motion jittered(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  Motion motion;
  double time_s = 0;
  for (std::size_t i = 0; i < count; ++i) {
    MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = time_s;
    for (std::size_t k = 0; k < kShapeCount; ++k) frame.weights[k] = static_cast<float>(random.uniform());
    frame.tongue_out = static_cast<float>(random.uniform());
    frame.head = random.rotation();
    // 30 fps with sub-frame jitter, and one frame in ten dropped.
    time_s += (1 / 30.0) * (random.chance(0.1) ? 2 : 1) + random.uniform(-0.002, 0.002);
  }
  return motion;
}

void expect_no_overshoot(const Motion& motion) {
  const MotionCurve curve(motion);
  for (std::size_t i = 0; i + 1 < motion.frames.size(); ++i) {
    const MotionFrame& a = motion.frames[i];
    const MotionFrame& b = motion.frames[i + 1];
    if (!a.has_face || !b.has_face) continue;
    EXPECT_EQ(curve.at(a.time_s).weights, a.weights) << "passes through its samples";
    for (const double u : {0.1, 0.35, 0.5, 0.8}) {
      const MotionFrame mid = curve.at(a.time_s + u * (b.time_s - a.time_s));
      for (std::size_t k = 0; k < kShapeCount; ++k) {
        ASSERT_GE(mid.weights[k], std::min(a.weights[k], b.weights[k]) - 1e-6F)
            << kShapeNames[k] << " at " << mid.time_s;
        ASSERT_LE(mid.weights[k], std::max(a.weights[k], b.weights[k]) + 1e-6F)
            << kShapeNames[k] << " at " << mid.time_s;
      }
    }
  }
}

TEST(MotionCurve, PassesThroughJitteredSamplesWithoutOvershoot) {
  expect_no_overshoot(jittered(1, 60));
}

TEST(MotionCurve, IsStraightWhereTheSamplesAre) {
  Motion motion;
  double time_s = 0;
  for (const double step : {0.0, 0.0331, 0.0667, 0.0334, 0.0329, 0.0667}) {
    time_s += step;
    MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = time_s;
    frame.weights[kJaw] = static_cast<float>(2 * time_s);
  }
  const MotionCurve curve(motion);
  for (double t = motion.frames[1].time_s; t < motion.frames[4].time_s; t += 0.005)
    EXPECT_NEAR(curve.at(t).weights[kJaw], 2 * t, 1e-5) << t;
}

TEST(MotionCurve, HoldsBeforeTheStartAndAfterTheEnd) {
  const Motion motion = jittered(2, 5);
  const MotionCurve curve(motion);
  EXPECT_EQ(curve.at(-3).weights, motion.frames.front().weights);
  EXPECT_EQ(curve.at(99).weights, motion.frames.back().weights);
  EXPECT_EQ(curve.at(99).time_s, 99);
  EXPECT_EQ(curve.duration_s(), motion.frames.back().time_s);
}

TEST(MotionCurve, BridgesAGapAndSaysThatItIsOne) {
  Motion motion;
  for (int i = 0; i < 10; ++i) {
    MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = 0.1 * i;
    frame.has_face = i < 3 || i > 6;
    frame.weights[kJaw] = frame.has_face ? static_cast<float>(0.1 * i) : 77.0F;  // Lost values must not leak.
  }
  const MotionCurve curve(motion);
  for (double t = 0.005; t <= 0.9; t += 0.01) {
    const MotionFrame frame = curve.at(t);
    EXPECT_LE(frame.weights[kJaw], 0.91F) << t;
    const bool inside = t > 0.2 && t < 0.7;
    EXPECT_EQ(frame.has_face, !inside) << t;
  }
  EXPECT_NEAR(curve.at(0.45).weights[kJaw], 0.45F, 1e-5);
}

TEST(MotionCurve, AHeadThatIsKnownGoesOnWhereTheFaceIsLost) {
  Motion motion;
  for (int i = 0; i < 10; ++i) {
    MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = 0.1 * i;
    frame.has_face = i < 3 || i > 6;
    frame.head_position_m = Vec3(0, i == 4 || i == 5 ? 1 : 0, 0);
  }
  // A camera that lost the face lost the head; virtual performers' heads are always known.
  EXPECT_EQ(MotionCurve(motion).at(0.45).head_position_m.y(), 0);
  motion.head_without_face = true;
  EXPECT_GE(MotionCurve(motion).at(0.45).head_position_m.y(), 1);
}

TEST(MotionCurve, AFaceThatIsLostAtTheEndsIsLostThere) {
  Motion motion;
  for (int i = 0; i < 6; ++i) {
    MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = 0.1 * i;
    frame.has_face = i > 1 && i < 4;
  }
  const MotionCurve curve(motion);
  EXPECT_FALSE(curve.at(0).has_face);
  EXPECT_FALSE(curve.at(0.15).has_face);
  EXPECT_TRUE(curve.at(0.25).has_face);
  EXPECT_FALSE(curve.at(0.45).has_face);
}

TEST(MotionCurve, OfNothingHasNoFace) {
  EXPECT_FALSE(MotionCurve(Motion{}).at(0).has_face);
  Motion lost;
  lost.frames.resize(1);
  lost.frames[0].has_face = false;
  EXPECT_FALSE(MotionCurve(lost).at(0).has_face);
}

TEST(MotionCurve, FollowsARealPerformanceOnItsOwnTimeCode) {
  const std::filesystem::path path = project_path("../shared/data/performances/alex_rom_3.csv");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path << ": the real performance is not here";
  auto motion = load_motion(path);
  ASSERT_TRUE(motion) << motion.error().message();
  motion->frames.resize(600);
  double shortest_s = 1;
  for (std::size_t i = 1; i < motion->frames.size(); ++i)
    shortest_s = std::min(shortest_s, motion->frames[i].time_s - motion->frames[i - 1].time_s);
  EXPECT_NEAR(shortest_s, 1 / 30.0, 0.001);
  expect_no_overshoot(*motion);
}

}  // namespace
}  // namespace mien::face::motion_test
