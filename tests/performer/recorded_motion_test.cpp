#include "mien/performer/recorded_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mien/core/time.h"

namespace mien::performer::recorded_motion_test {
namespace {

using face::shape;

/// Twenty seconds at 30 Hz: the jaw opens with the lower lip, the left brow by itself; cheeks rest at 0.2.
face::Motion recording() {
  face::Motion motion;
  for (int i = 0; i < 600; ++i) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = i / 30.0;
    const auto wave = static_cast<float>(0.5 - 0.5 * std::cos(3 * frame.time_s));
    frame.weights[shape("jawOpen")] = 0.6F * wave;
    frame.weights[shape("mouthLowerDown_L")] = 0.3F * wave;
    frame.weights[shape("browDown_L")] = 0.4F * static_cast<float>(0.5 - 0.5 * std::cos(1.7 * frame.time_s));
    frame.weights[shape("cheekSquint_L")] = 0.2F;
  }
  return motion;
}

face::Motion perform(std::uint64_t seed) {
  const std::array recordings = {recording()};
  return perform_recorded(recordings, 30, plain_style(), Random(seed));
}

TEST(PerformRecorded, GivesSixtyFramesASecondWithinWhatWeightsAre) {
  const face::Motion motion = perform(1);
  ASSERT_EQ(motion.frames.size(), 1800U);
  EXPECT_FALSE(motion.has_head);
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    EXPECT_NEAR(motion.frames[i].time_s, static_cast<double>(i) / kFrameRateHz, 1e-6);
    for (const float weight : motion.frames[i].weights.values) {
      EXPECT_GE(weight, 0);
      EXPECT_LE(weight, 1);
    }
  }
}

TEST(PerformRecorded, KeepsWhatGoesTogetherAndHowFast) {
  const std::size_t jaw = shape("jawOpen");
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const face::Motion motion = perform(seed);
    double jaw_jaw = 0, lip_lip = 0, jaw_lip = 0, fastest = 0, largest = 0;
    for (std::size_t i = 0; i < motion.frames.size(); ++i) {
      const auto& weights = motion.frames[i].weights;
      const double lip = weights[shape("mouthLowerDown_L")] +
                         weights[shape("mouthLowerDown_R")];  // Whichever the mirror has.
      jaw_jaw += weights[jaw] * weights[jaw];
      lip_lip += lip * lip;
      jaw_lip += weights[jaw] * lip;
      largest = std::max<double>(largest, weights[jaw]);
      if (i > 0)
        fastest = std::max<double>(fastest, std::abs(weights[jaw] - motion.frames[i - 1].weights[jaw]));
    }
    EXPECT_GT(jaw_lip / std::sqrt(jaw_jaw * lip_lip), 0.97) << seed;
    EXPECT_GT(largest, 0.25) << seed;
    EXPECT_LT(fastest * kFrameRateHz, 5) << seed << ": clips follow each other without a jump";
  }
}

TEST(PerformRecorded, MirrorsHalfOfThePerformances) {
  int mirrored_ones = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const face::BlendshapeWeights weights = perform(seed).frames[300].weights;
    if (weights[shape("cheekSquint_R")] > weights[shape("cheekSquint_L")]) ++mirrored_ones;
  }
  EXPECT_GT(mirrored_ones, 10);
  EXPECT_LT(mirrored_ones, 30);
}

TEST(PerformRecorded, IsTheSameOfTheSameSeedAlone) {
  const face::Motion first = perform(3), again = perform(3), other = perform(4);
  for (std::size_t i = 0; i < first.frames.size(); ++i)
    ASSERT_EQ(first.frames[i].weights.values, again.frames[i].weights.values);
  EXPECT_NE(first.frames[500].weights.values, other.frames[500].weights.values);
}

TEST(PerformRecorded, BridgesFramesWithoutAFaceAndRepeatsAShortRecording) {
  face::Motion lost = recording();
  lost.frames.resize(60);
  for (std::size_t i = 10; i < 30; ++i) {
    lost.frames[i].has_face = false;
    lost.frames[i].weights.values.fill(99);
  }
  const std::array recordings = {lost};
  const face::Motion motion = perform_recorded(recordings, 10, plain_style(), Random(1));
  EXPECT_EQ(motion.frames.size(), 600U);
  for (const face::MotionFrame& frame : motion.frames)
    EXPECT_LE(*std::ranges::max_element(frame.weights.values), 1);
}

TEST(Mirrored, SwapsSidesAndIsItsOwnInverse) {
  face::BlendshapeWeights weights;
  for (std::size_t k = 0; k < face::kShapeCount; ++k) weights[k] = 0.01F * static_cast<float>(k);
  const face::BlendshapeWeights seen = mirrored(weights);
  EXPECT_EQ(seen[shape("mouthSmile_L")], weights[shape("mouthSmile_R")]);
  EXPECT_EQ(seen[shape("eyeLookIn_L")], weights[shape("eyeLookIn_R")]);
  EXPECT_EQ(seen[shape("jawLeft")], weights[shape("jawRight")]);
  EXPECT_EQ(seen[shape("mouthRight")], weights[shape("mouthLeft")]);
  EXPECT_EQ(seen[shape("jawOpen")], weights[shape("jawOpen")]);
  EXPECT_EQ(mirrored(seen).values, weights.values);
}

}  // namespace
}  // namespace mien::performer::recorded_motion_test
