#include "mien/synthetic/speech/closure_score.h"

#include <gtest/gtest.h>

namespace mien::synthetic::closure_score_test {
namespace {

TEST(ClosureScore, OneHeardBelongsToOneTrue) {
  const std::vector<Closure> truth = {{1, 1.06}, {1.5, 1.56}, {2, 2.06}};
  const auto exact = score_closures(truth, truth);
  EXPECT_EQ(exact.recall(), 1);
  EXPECT_EQ(exact.false_share(), 0);
  // Late by what is allowed, by more, and one of nothing.
  const auto some =
      score_closures(truth, std::vector<Closure>{{1.1, 1.16}, {1.7, 1.75}, {2.05, 2.1}, {3, 3.1}});
  EXPECT_EQ(some.found, 2U);
  EXPECT_NEAR(some.recall(), 2.0 / 3, 1e-12);
  EXPECT_NEAR(some.false_share(), 0.5, 1e-12);
}

TEST(ClosureScore, AMouthThatIsAlwaysClosedFindsOne) {
  const std::vector<Closure> truth = {{1, 1.06}, {1.5, 1.56}, {2, 2.06}};
  EXPECT_EQ(score_closures(truth, std::vector<Closure>{{0, 10}}).found, 1U);
  EXPECT_EQ(score_closures(truth, {}).recall(), 0);
  EXPECT_EQ(score_closures({}, truth).false_share(), 1);
}

TEST(ClosureScore, StretchesOfATrack) {
  const std::vector<float> track = {0, 1, 1, 0, 0.4F, 0.5F};
  const auto stretches = stretches_above(track, 0.5F, 0, 0.02);
  ASSERT_EQ(stretches.size(), 2U);
  EXPECT_NEAR(stretches[0].begin_s, 0.01, 1e-12);
  EXPECT_NEAR(stretches[0].end_s, 0.05, 1e-12);
  EXPECT_NEAR(stretches[1].begin_s, 0.09, 1e-12);
  EXPECT_TRUE(stretches_above(std::vector<float>{}, 0.5F, 0, 0.02).empty());
}

}  // namespace
}  // namespace mien::synthetic::closure_score_test
