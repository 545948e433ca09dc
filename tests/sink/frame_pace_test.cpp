#include "mien/sink/frame_pace.h"

#include <gtest/gtest.h>

namespace mien::sink::frame_pace_test {
namespace {

int due_count(FramePace& pace, std::int64_t from, std::int64_t to, std::int64_t step = 1) {
  int count = 0;
  for (std::int64_t i = from; i < to; i += step) {
    if (!pace.due(i)) continue;
    ++count;
    pace.sent();
  }
  return count;
}

TEST(FramePace, SendsItsShareOfTheGrid) {
  for (int rate = 1; rate <= 60; ++rate) {
    FramePace pace(rate);
    EXPECT_EQ(due_count(pace, 0, 600), rate * 10) << rate;
    EXPECT_EQ(pace.measured_hz(), rate);
    FramePace before(rate);
    EXPECT_EQ(due_count(before, -600, 0), rate * 10) << rate;
  }
}

TEST(FramePace, SpreadsItsShareEvenly) {
  FramePace pace(24);
  std::int64_t last = -1;
  for (std::int64_t i = 0; i < 6000; ++i) {
    if (!pace.due(i)) continue;
    if (last >= 0) {
      EXPECT_GE(i - last, 2);
      EXPECT_LE(i - last, 3);
    }
    last = i;
  }
}

TEST(FramePace, TakesTheNextWhereFramesAreMissing) {
  FramePace pace(30);
  EXPECT_EQ(due_count(pace, 0, 600, 2), 300);
  EXPECT_EQ(due_count(pace, 601, 1201, 2), 300);
  EXPECT_TRUE(pace.due(5000));
  pace.sent();
  EXPECT_EQ(pace.measured_hz(), 1);
}

TEST(FramePace, BeginsAgainWhereTimeGoesBack) {
  FramePace pace(1);
  EXPECT_TRUE(pace.due(1000));
  EXPECT_FALSE(pace.due(1001));
  EXPECT_TRUE(pace.due(10));
  EXPECT_TRUE(pace.due(10));
}

TEST(FramePace, CountsWhatBecameOfThem) {
  FramePace pace(60);
  EXPECT_EQ(pace.measured_hz(), 0);
  for (int i = 0; i < 60; ++i) {
    EXPECT_TRUE(pace.due(i));
    if (i % 3 == 0)
      pace.failed();
    else
      pace.sent();
  }
  EXPECT_EQ(pace.sent_count(), 40u);
  EXPECT_EQ(pace.failed_count(), 20u);
  EXPECT_EQ(pace.measured_hz(), 40);
  pace.undelivered();
  EXPECT_EQ(pace.sent_count(), 39u);
  EXPECT_EQ(pace.failed_count(), 21u);
  EXPECT_EQ(pace.measured_hz(), 39);
  FramePace none(60);
  none.undelivered();
  EXPECT_EQ(none.sent_count(), 0u);
}

}  // namespace
}  // namespace mien::sink::frame_pace_test
