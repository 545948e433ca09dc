#include "mien/core/streaming_mode.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "mien/core/random.h"
#include "tests/allocation_count.h"

namespace mien::streaming_mode_test {
namespace {

/// The middle of a bin.
float of_bin(int bin) {
  return static_cast<float>(bin) / 63;
}

void add(StreamingMode& mode, int bin, int times) {
  for (int i = 0; i < times; ++i) mode.add(of_bin(bin));
}

TEST(StreamingMode, KnowsNothingBeforeTheFirstValue) {
  const StreamingMode mode;
  EXPECT_EQ(mode.count(), 0U);
  EXPECT_EQ(mode.mode(), 0);
  EXPECT_EQ(mode.upper(0.02), 0);
}

TEST(StreamingMode, OfOneValueIsItsBin) {
  for (const int bin : {0, 1, 17, 62, 63}) {
    StreamingMode mode;
    add(mode, bin, 1);
    EXPECT_DOUBLE_EQ(mode.mode(), bin / 63.0);
    add(mode, bin, 5000);
    EXPECT_DOUBLE_EQ(mode.mode(), bin / 63.0);
    EXPECT_EQ(mode.count(), StreamingMode::kWindow);
  }
  StreamingMode between;
  between.add(0.25F);  // 15.75 of 63: nearest 16.
  EXPECT_DOUBLE_EQ(between.mode(), 16 / 63.0);
}

TEST(StreamingMode, IsRefinedByTheParabola) {
  // Counts 2, 6, 4 in bins 10 to 12: smoothed 2, 10, 18, 14, 4 in bins 9 to 13. The parabola through 10, 18
  // and 14 has its top 0.5 (10 - 14) / (10 - 36 + 14) = 1/6 above bin 11.
  StreamingMode mode;
  add(mode, 10, 2);
  add(mode, 11, 6);
  add(mode, 12, 4);
  EXPECT_DOUBLE_EQ(mode.mode(), (11 + 1 / 6.0) / 63);
}

TEST(StreamingMode, SmoothingPrefersABroadHillToAHighSpike) {
  StreamingMode mode;
  add(mode, 40, 11);                                     // Smoothed 22.
  for (const int bin : {20, 21, 22}) add(mode, bin, 8);  // Smoothed 32 in bin 21.
  EXPECT_DOUBLE_EQ(mode.mode(), 21 / 63.0);
}

TEST(StreamingMode, OfTwoAlikeTheLowerIsTaken) {
  StreamingMode mode;
  add(mode, 50, 9);
  add(mode, 5, 9);
  EXPECT_DOUBLE_EQ(mode.mode(), 5 / 63.0);
  StreamingMode neighbours;  // As high in both: the top lies between them.
  add(neighbours, 1, 7);
  add(neighbours, 2, 7);
  EXPECT_DOUBLE_EQ(neighbours.mode(), 1.5 / 63);
}

TEST(StreamingMode, AtTheEndsIsTheEnd) {
  StreamingMode mode;
  add(mode, 0, 9);
  add(mode, 1, 6);  // Smoothed 24 and 21.
  EXPECT_EQ(mode.mode(), 0);
  add(mode, 1, 4);  // 28 and 29, then 10: 0.5 (28 - 10) / (28 - 58 + 10) = -0.45.
  EXPECT_DOUBLE_EQ(mode.mode(), 0.55 / 63);
  StreamingMode top;
  add(top, 63, 9);
  add(top, 62, 6);
  EXPECT_EQ(top.mode(), 1);
}

TEST(StreamingMode, WhatTheTopExceeds) {
  StreamingMode mode;
  add(mode, 10, 90);
  add(mode, 60, 10);
  // A tenth lies in bin 60: all of it at its lower edge, half of it at its middle.
  EXPECT_DOUBLE_EQ(mode.upper(0.10), 59.5 / 63);
  EXPECT_DOUBLE_EQ(mode.upper(0.05), 60 / 63.0);
  EXPECT_DOUBLE_EQ(mode.upper(0), 60.5 / 63);
  // Another 45 of the 90 in bin 10.
  EXPECT_DOUBLE_EQ(mode.upper(0.55), 10 / 63.0);
  EXPECT_DOUBLE_EQ(mode.upper(1), 9.5 / 63);
  StreamingMode full;
  add(full, 63, 3);
  EXPECT_EQ(full.upper(0.02), 1);
}

TEST(StreamingMode, ForgetsWhatIsOlderThanTheWindow) {
  StreamingMode mode;
  add(mode, 40, 1000);
  add(mode, 8, 899);  // 901 of the thousand are left.
  EXPECT_DOUBLE_EQ(mode.mode(), 40 / 63.0);
  add(mode, 8, 2);  // 899 against 901.
  EXPECT_DOUBLE_EQ(mode.mode(), 8 / 63.0);
}

TEST(StreamingMode, AgreesWithCountingAnew) {
  Random random(3);
  StreamingMode mode;
  std::vector<float> all;
  for (int i = 0; i < 6000; ++i) {
    all.push_back(static_cast<float>(random.uniform(i < 3000 ? -0.2 : 0.1, i % 3 == 0 ? 0.4 : 1.2)));
    mode.add(all.back());
    if (i % 501 != 0) continue;
    StreamingMode again;
    const std::size_t from = all.size() - std::min(all.size(), StreamingMode::kWindow);
    for (std::size_t k = from; k < all.size(); ++k) again.add(all[k]);
    ASSERT_EQ(mode.mode(), again.mode()) << i;
    ASSERT_EQ(mode.upper(0.02), again.upper(0.02)) << i;
    ASSERT_EQ(mode.count(), all.size() - from);
  }
}

TEST(StreamingMode, TakesNothingThatIsNotFiniteAndHoldsTheRest) {
  StreamingMode mode;
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()})
    mode.add(bad);
  EXPECT_EQ(mode.count(), 0U);
  mode.add(1e30F);
  EXPECT_EQ(mode.mode(), 1);
  mode.add(-1e30F);
  mode.add(-1e30F);
  EXPECT_EQ(mode.mode(), 0);
  EXPECT_EQ(mode.count(), 3U);
}

TEST(StreamingMode, BeginsAnewAndAllocatesNothing) {
  const std::size_t before = test::allocation_count();
  StreamingMode mode;
  add(mode, 30, 2000);
  mode.reset();
  EXPECT_EQ(mode.count(), 0U);
  EXPECT_EQ(mode.mode(), 0);
  add(mode, 4, 1);
  EXPECT_DOUBLE_EQ(mode.mode(), 4 / 63.0);
  EXPECT_DOUBLE_EQ(mode.upper(0.5), 4 / 63.0);
  EXPECT_EQ(test::allocation_count(), before);
}

}  // namespace
}  // namespace mien::streaming_mode_test
