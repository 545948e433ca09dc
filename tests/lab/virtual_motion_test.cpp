#include "lab/virtual_motion.h"

#include <gtest/gtest.h>

namespace mien::lab::virtual_motion_test {
namespace {

VirtualMotionRequest brief(unsigned threads) {
  return {.performers = 2, .seconds = 8, .seed = 3, .threads = threads};
}

TEST(VirtualMotion, IsTheSameOnAnyNumberOfThreads) {
  const auto one = virtual_motion(brief(1), no_progress);
  const auto two = virtual_motion(brief(2), no_progress);
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_TRUE(two) << two.error().message();
  ASSERT_EQ(one->size(), 5U);
  EXPECT_EQ(one->front().name, "range_of_motion");
  EXPECT_EQ(measure::comparison_markdown(*one, one->size()), measure::comparison_markdown(*two, two->size()));
  for (const measure::MotionStatistics& kind : *one) {
    EXPECT_NEAR(kind.duration_s, 2 * 8, 0.2) << kind.name;
    EXPECT_GT(kind.mean_deviation, 0) << kind.name;
  }
  EXPECT_GT(one->at(1).mean_deviation, one->at(3).mean_deviation) << "free is wider than reading";
}

TEST(VirtualMotion, NeedsSomebodyWhoMoves) {
  EXPECT_EQ(virtual_motion({.performers = 0}, no_progress).error().code, ErrorCode::bad_usage);
  EXPECT_EQ(virtual_motion({.seconds = 0.5}, no_progress).error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::lab::virtual_motion_test
