#include "mien/tracker/answer_correction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/allocation_count.h"

namespace mien::tracker::answer_correction_test {
namespace {

constexpr std::size_t kJaw = face::shape("jawOpen"), kPuff = face::shape("cheekPuff_L");

/// The jaw gains half of the puff of now and takes off a quarter of the jaw of three frames before.
model::Correction correction() {
  model::Correction made{.lags = {0, 3}, .weights = std::vector<float>(53 * 2 * 53, 0.0F)};
  made.weights[kJaw * 2 * 53 + kPuff] = 0.5F;
  made.weights[kJaw * 2 * 53 + 53 + kJaw] = -0.25F;
  return made;
}

TEST(AnswerCorrection, AddsWhatFollowsFromAnswersOfNowAndBefore) {
  const AnswerCorrection applied(correction());
  AnswerCorrection::History history(applied);
  for (int f = 0; f < 12; ++f) {
    face::BlendshapeWeights weights;
    weights[kJaw] = 0.1F + 0.05F * static_cast<float>(f);
    weights[kPuff] = 0.2F;
    applied.apply(history, weights);
    const float before = 0.1F + 0.05F * static_cast<float>(std::max(0, f - 3));
    EXPECT_NEAR(weights[kJaw], 0.1F + 0.05F * static_cast<float>(f) + 0.1F - 0.25F * before, 1e-6F) << f;
    EXPECT_EQ(weights[kPuff], 0.2F);
  }
}

TEST(AnswerCorrection, LeavesAFaceAtRestAndStaysWithinWeights) {
  const AnswerCorrection applied(correction());
  AnswerCorrection::History history(applied);
  face::BlendshapeWeights rest;
  applied.apply(history, rest);
  EXPECT_EQ(rest, face::BlendshapeWeights{});
  face::BlendshapeWeights wide;
  wide[kJaw] = wide[kPuff] = 1;
  applied.apply(history, wide);
  EXPECT_EQ(wide[kJaw], 1);
}

TEST(AnswerCorrection, ForgetsAndAllocatesNothing) {
  const AnswerCorrection applied(correction());
  AnswerCorrection::History history(applied), fresh(applied);
  face::BlendshapeWeights first, second;
  first[kJaw] = second[kJaw] = 0.4F;
  face::BlendshapeWeights other;
  other[kJaw] = 0.9F;
  applied.apply(history, other);
  history.reset();
  const std::size_t before = mien::test::allocation_count();
  applied.apply(history, first);
  EXPECT_EQ(mien::test::allocation_count(), before);
  applied.apply(fresh, second);
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace mien::tracker::answer_correction_test
