#include "mien/core/median.h"

#include <gtest/gtest.h>

namespace mien::median_test {
namespace {

TEST(UpperMedian, IsOneOfTheValuesInWhateverOrder) {
  EXPECT_EQ(upper_median(std::vector{7}), 7);
  EXPECT_EQ(upper_median(std::vector{9.0, 1.0, 4.0}), 4.0);
  EXPECT_EQ(upper_median(std::vector{9, 1, 4, 2}), 4);
}

}  // namespace
}  // namespace mien::median_test
