#include "mien/headset/confidence_gain.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace mien::headset::confidence_gain_test {
namespace {

constexpr std::size_t kJaw = face::shape("jawOpen"), kBlink = face::shape("eyeBlink_L");

/// All regions are as sure.
ConfidenceGain::Confidence everywhere(float confidence) {
  ConfidenceGain::Confidence all{};
  all.fill(confidence);
  return all;
}

/// What is shown of a frame in which the jaw and a lid are this far.
struct Shown {
  float jaw, blink;
};
Shown show(ConfidenceGain& gain, float confidence, float found) {
  Answer answer;
  answer.weights[kJaw] = answer.weights[kBlink] = answer.tongue_out = found;
  gain.apply(everywhere(confidence), answer);
  EXPECT_EQ(answer.tongue_out, answer.weights[kJaw]) << "the tongue goes with the jaw";
  return {answer.weights[kJaw], answer.weights[kBlink]};
}

TEST(ConfidenceGain, WhatIsSurePassesToTheBit) {
  ConfidenceGain gain;
  for (const float found : {0.0F, 0.7F, 0.1F, 1.0F, 0.3F}) EXPECT_EQ(show(gain, 0.9F, found).jaw, found);
}

TEST(ConfidenceGain, WhatIsDoubtedMovesTheLowerFaceLittle) {
  ConfidenceGain gain;
  show(gain, 0.95F, 0.2F);
  for (int frame = 0; frame < 6; ++frame) {
    const Shown shown = show(gain, 0.05F, 0.9F);
    EXPECT_NEAR(shown.jaw, 0.2F, 0.1F) << frame;
    EXPECT_EQ(shown.blink, 0.9F) << "lids are quick";
  }
}

TEST(ConfidenceGain, EachRegionIsDoubtedByItself) {
  ConfidenceGain gain;
  Answer answer;
  gain.apply(everywhere(0.95F), answer);
  ConfidenceGain::Confidence confidence = everywhere(0.95F);
  confidence[static_cast<std::size_t>(face::ShapeRegion::jaw)] = 0.01F;
  answer.weights.values.fill(0.9F);
  gain.apply(confidence, answer);
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (face::kShapeRegions[k] == face::ShapeRegion::jaw)
      EXPECT_LT(answer.weights[k], 0.1F) << k;
    else
      EXPECT_EQ(answer.weights[k], 0.9F) << k;
}

TEST(ConfidenceGain, AConfidenceThatFallsIsTakenForWhatItWillBe) {
  ConfidenceGain leads, lags({.lead_frames = 0});
  for (ConfidenceGain* const gain : {&leads, &lags}) show(*gain, 0.99F, 0.2F);
  EXPECT_LT(show(leads, 0.7F, 0.9F).jaw, 0.25F);
  EXPECT_EQ(show(lags, 0.7F, 0.9F).jaw, 0.9F) << "0.7 is sure enough by itself";
}

TEST(ConfidenceGain, ComesBackWithoutAJump) {
  ConfidenceGain gain;
  show(gain, 0.95F, 0.2F);
  for (int frame = 0; frame < 10; ++frame) show(gain, 0.01F, 0.2F);
  float before = 0.2F, most = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const float now = show(gain, 0.95F, 0.9F).jaw;
    EXPECT_GE(now, before);
    most = std::max(most, now - before);
    before = now;
  }
  EXPECT_LT(most, 0.1F);
  EXPECT_FLOAT_EQ(before, 0.9F);
}

TEST(ConfidenceGain, BeginsAnewWithWhatIsFound) {
  ConfidenceGain gain;
  show(gain, 0.95F, 0.2F);
  gain.reset();
  EXPECT_EQ(show(gain, 0.01F, 0.9F).jaw, 0.9F);
}

TEST(ConfidenceGain, CertaintyIsANumberToo) {
  ConfidenceGain gain;
  for (const float confidence : {1.0F, 0.0F, 1.0F, 0.0F}) {
    const float jaw = show(gain, confidence, 0.5F).jaw;
    EXPECT_GE(jaw, 0.0F);
    EXPECT_LE(jaw, 1.0F);
  }
}

}  // namespace
}  // namespace mien::headset::confidence_gain_test
