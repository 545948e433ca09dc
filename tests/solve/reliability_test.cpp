#include "mien/solve/reliability.h"

#include <gtest/gtest.h>

namespace mien::solve::reliability_test {
namespace {

TEST(Reliability, IsTheMeanDistanceOfSaidAndTrue) {
  Reliability one;
  EXPECT_EQ(one.expected_error(), 0);
  for (int i = 0; i < 10; ++i) one.add(0.75F, i < 5);  // A quarter too sure.
  for (int i = 0; i < 30; ++i) one.add(1, true);
  EXPECT_NEAR(one.expected_error(), 0.25 * 10 / 40, 1e-6);
  Reliability two;
  two.add(one);
  EXPECT_EQ(two.expected_error(), one.expected_error());
}

TEST(RocArea, IsTheShareOfPairsInTheRightOrder) {
  RocArea area;
  EXPECT_EQ(area.area(), 0.5) << "of nothing";
  // Came true at 0.9, 0.5 and 0.3, did not at 0.6 and 0.3: of six pairs 0.9 wins two, 0.5 one, 0.3 half of
  // one.
  for (const float confidence : {0.9F, 0.5F, 0.3F}) area.add(confidence, true);
  EXPECT_EQ(area.area(), 0.5) << "nothing to tell it from";
  RocArea beyond;
  for (const float confidence : {0.6F, 0.3F}) beyond.add(confidence, false);
  area.add(beyond);
  EXPECT_DOUBLE_EQ(area.area(), 3.5 / 6);
  RocArea ends;
  ends.add(1, true);
  ends.add(0, false);
  EXPECT_EQ(ends.area(), 1);
}

}  // namespace
}  // namespace mien::solve::reliability_test
