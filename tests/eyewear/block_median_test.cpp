#include "mien/eyewear/ambient.h"

#include <gtest/gtest.h>

namespace mien::eyewear::block_median_test {
namespace {

TEST(BlockMedian, GivesOneValueForTen) {
  BlockMedian median;
  for (int block = 0; block < 3; ++block) {
    for (int i = 0; i < 9; ++i) EXPECT_FALSE(median.add(static_cast<float>(9 - i)));
    EXPECT_FLOAT_EQ(median.add(0).value(), 4.5F);
  }
}

TEST(BlockMedian, ShrugsOffFlashesOfLessThanHalf) {
  BlockMedian median;
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(median.add(i < 4 ? 0.9F : 0.3F));
  EXPECT_FLOAT_EQ(median.add(0.3F).value(), 0.3F);
}

TEST(BlockMedian, ForgetsAnUnfinishedTen) {
  BlockMedian median;
  for (int i = 0; i < 7; ++i) EXPECT_FALSE(median.add(100));
  median.reset();
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(median.add(1));
  EXPECT_FLOAT_EQ(median.add(1).value(), 1);
}

}  // namespace
}  // namespace mien::eyewear::block_median_test
