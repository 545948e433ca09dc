#include "mien/performer/mimic.h"

#include <gtest/gtest.h>

#include <array>

namespace mien::performer::mimic_test {
namespace {

using face::shape;

PoseCue smile_at(double begin_s) {
  PoseCue cue{begin_s, {}};
  cue.target[shape("mouthSmile_L")] = 0.8F;
  cue.target[shape("mouthSmile_R")] = 0.8F;
  return cue;
}

TEST(Mimic, APerfectMimicDoesWhatIsShown) {
  const Mimicry perfect{.least_gain = 1,
                        .most_gain = 1,
                        .least_late_s = 0,
                        .most_late_s = 0,
                        .most_unasked = 0,
                        .slackening = 0,
                        .tremor = 0,
                        .blinks_per_min = 0};
  const std::array<PoseCue, 2> cues = {smile_at(1), PoseCue{4, {}}};
  const face::Motion motion = mimic(cues, 7, perfect, Random(1));
  ASSERT_EQ(motion.frames.size(), 421u);
  EXPECT_EQ(motion.frames[30].weights, face::BlendshapeWeights{});
  EXPECT_NEAR(motion.frames[180].weights[shape("mouthSmile_L")], 0.8, 1e-6);
  EXPECT_EQ(motion.frames[180].weights[shape("jawOpen")], 0);
  EXPECT_EQ(motion.frames[400].weights, face::BlendshapeWeights{});
}

TEST(Mimic, PeopleAreLateAndMissWhatIsShown) {
  const std::array<PoseCue, 1> cues = {smile_at(1)};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const face::Motion motion = mimic(cues, 4, {}, Random(seed));
    EXPECT_EQ(motion.frames[68].weights[shape("mouthSmile_L")], 0) << seed;
    const float smile = motion.frames[150].weights[shape("mouthSmile_L")];
    EXPECT_GT(smile, 0.35F);
    EXPECT_LT(smile, 1.11F);
    EXPECT_NE(smile, motion.frames[150].weights[shape("mouthSmile_R")]);
    int moving = 0;
    for (const float weight : motion.frames[150].weights.values) moving += weight > 0.002F ? 1 : 0;
    EXPECT_GE(moving, 2);
    EXPECT_LE(moving, 7);
  }
}

TEST(Mimic, StaysWithinWhatAFaceCanDo) {
  std::vector<PoseCue> cues;
  Random random(5);
  for (int i = 0; i < 40; ++i) {
    PoseCue cue{0.5 * i, {}};
    for (float& weight : cue.target.values) weight = static_cast<float>(random.uniform());
    cues.push_back(cue);
  }
  for (const face::MotionFrame& frame : mimic(cues, 20, {}, Random(1)).frames)
    for (const float weight : frame.weights.values) {
      EXPECT_GE(weight, 0);
      EXPECT_LE(weight, 1.1F);
    }
}

TEST(Mimic, TheSameDrawsGiveTheSameMotion) {
  const std::array<PoseCue, 1> cues = {smile_at(1)};
  const auto last = [&](std::uint64_t seed) {
    return mimic(cues, 3, {}, Random(seed)).frames.back().weights;
  };
  EXPECT_EQ(last(1), last(1));
  EXPECT_NE(last(1), last(2));
}

}  // namespace
}  // namespace mien::performer::mimic_test
