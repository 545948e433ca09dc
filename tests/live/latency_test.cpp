#include "mien/live/latency.h"

#include <gtest/gtest.h>

namespace mien::live::latency_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

TEST(Latencies, AreNothingWhileThereAreNone) {
  const Latencies none;
  EXPECT_EQ(none.count(), 0u);
  EXPECT_EQ(none.percentile(0.5), Duration());
  EXPECT_EQ(none.largest(), Duration());
}

TEST(Latencies, GivePercentilesToThreePercentAndTheLargestExactly) {
  Latencies all;
  for (int i = 1; i <= 1000; ++i) all.add(microseconds(i));
  EXPECT_EQ(all.count(), 1000u);
  for (const double share : {0.01, 0.5, 0.9, 0.99}) {
    const double us = 1e6 * to_seconds(all.percentile(share));
    EXPECT_GE(us, 1000 * share) << share;
    EXPECT_LE(us, 1000 * share * 1.031) << share;
  }
  EXPECT_EQ(all.percentile(1), microseconds(1000));
  EXPECT_EQ(all.percentile(0), all.percentile(0.001));
  EXPECT_EQ(all.largest(), microseconds(1000));
}

TEST(Latencies, TakeWhatIsBelowAndBeyondTheirBins) {
  Latencies all;
  all.add(Duration(-5));  // A clock that was read the other way round.
  all.add(Duration(0));
  EXPECT_EQ(all.largest(), Duration(0));
  EXPECT_EQ(all.percentile(0.5), Duration(0)) << "no more than the largest";
  all.add(std::chrono::hours(24));
  EXPECT_EQ(all.largest(), std::chrono::hours(24));
  EXPECT_EQ(all.percentile(1), std::chrono::hours(24)) << "not the end of the last bin";
}

TEST(Latencies, AddUp) {
  Latencies calm, busy;
  for (int i = 0; i < 90; ++i) calm.add(milliseconds(1));
  for (int i = 0; i < 10; ++i) busy.add(milliseconds(20));
  calm += busy;
  EXPECT_EQ(calm.count(), 100u);
  EXPECT_NEAR(to_seconds(calm.percentile(0.9)), 1e-3, 0.031e-3);
  EXPECT_NEAR(to_seconds(calm.percentile(0.91)), 20e-3, 0.62e-3);
  EXPECT_EQ(calm.largest(), milliseconds(20));
  calm.clear();
  EXPECT_EQ(calm.count(), 0u);
  EXPECT_EQ(calm.largest(), Duration());
}

}  // namespace
}  // namespace mien::live::latency_test
