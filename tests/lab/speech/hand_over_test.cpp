#include "lab/speech/hand_over.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/builtin_face/builtin_face.h"

namespace mien::lab::hand_over_test {
namespace {

using face::OutputFrame;
using face::Provenance;

/// Two seconds of a jaw that opens and closes, seen.
std::vector<OutputFrame> seen() {
  std::vector<OutputFrame> frames(120);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    frames[f].time = DeviceTime(frame_offset(static_cast<std::int64_t>(f)));
    frames[f].weights[face::shape("jawOpen")] =
        static_cast<float>(0.3 + 0.3 * std::sin(0.2 * static_cast<double>(f)));
    frames[f].provenance.fill(Provenance::measured);
  }
  return frames;
}

HandOver judge(const std::vector<OutputFrame>& shown) {
  static const measure::Meter meter(builtin_face::make_builtin());
  const std::vector<OutputFrame> steady = seen();
  std::vector<face::BlendshapeWeights> truth;
  for (const OutputFrame& frame : steady) truth.push_back(frame.weights);
  return judge_hand_over({.lost = 40, .back = 80},
                         {.shown = shown, .steady = steady, .meanwhile = steady, .truth = truth}, meter);
}

TEST(HandOver, NothingThatChangesHandsIsNeverNoticed) {
  const HandOver over = judge(seen());
  EXPECT_TRUE(std::isinf(over.notice_s));
  EXPECT_EQ(over.recover_s, 0);
  EXPECT_DOUBLE_EQ(over.jerk_ratio, 1);
  EXPECT_EQ(over.mouth_mm, 0);
}

TEST(HandOver, TellsWhenItWasNoticedAndWhenItWasOver) {
  std::vector<OutputFrame> shown = seen();
  for (std::size_t f = 46; f < 92; ++f) {
    shown[f].provenance.fill(Provenance::held);
    shown[f].weights = shown[45].weights;
  }
  HandOver over = judge(shown);
  EXPECT_NEAR(over.notice_s, 0.1, 1e-9);
  EXPECT_NEAR(over.recover_s, 0.2, 1e-9);
  EXPECT_GT(over.mouth_mm, 0.1);
  EXPECT_GT(over.jerk_ratio, 2) << "it jumps back";
  for (std::size_t f = 92; f < shown.size(); ++f) shown[f].provenance.fill(Provenance::held);
  EXPECT_TRUE(std::isinf(judge(shown).recover_s));
  // One weight that still claims to be seen is enough not to have noticed; what is no mouth does not count.
  shown[50].provenance[face::shape("jawOpen")] = Provenance::predicted;
  EXPECT_NEAR(judge(shown).notice_s, 0.1, 1e-9);
  for (std::size_t f = 46; f < 60; ++f) shown[f].provenance[face::shape("jawOpen")] = Provenance::predicted;
  EXPECT_NEAR(judge(shown).notice_s, 20 / 60.0, 1e-9);
}

}  // namespace
}  // namespace mien::lab::hand_over_test
