#include "mien/core/time.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace mien::time_test {
namespace {

static_assert(!std::is_convertible_v<DeviceTime, HostTime>, "only a clock model may turn one into the other");
static_assert(!std::is_constructible_v<HostTime, DeviceTime>);
static_assert(frame_offset(60) == std::chrono::seconds(1));

TEST(Time, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(1.25).count(), 1'250'000'000);
  EXPECT_EQ(from_seconds(0.4e-9).count(), 0);
  EXPECT_EQ(from_seconds(0.6e-9).count(), 1);
  EXPECT_EQ(from_seconds(-0.6e-9).count(), -1);
  EXPECT_EQ(from_seconds(-1.5).count(), -1'500'000'000);
}

TEST(Time, SecondsSurviveARoundTripOver100Days) {
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{16'666'667}, std::int64_t{3'600'000'000'001},
        std::int64_t{100} * 86'400 * 1'000'000'000 / 2})
    EXPECT_EQ(from_seconds(to_seconds(Duration{ns})).count(), ns);
}

TEST(Time, FramesDoNotDrift) {
  EXPECT_EQ(frame_offset(0).count(), 0);
  EXPECT_EQ(frame_offset(1).count(), 16'666'667);
  EXPECT_EQ(frame_offset(2).count(), 33'333'333);
  EXPECT_EQ(frame_offset(3).count(), 50'000'000);
  EXPECT_EQ(frame_offset(-1).count(), -16'666'667);
  // A day of frames ends where a day ends.
  EXPECT_EQ(frame_offset(60LL * 86'400), std::chrono::hours(24));
  for (std::int64_t i = -1000; i < 1000; ++i) {
    const auto step = (frame_offset(i + 1) - frame_offset(i)).count();
    EXPECT_TRUE(step == 16'666'666 || step == 16'666'667) << i;
  }
}

}  // namespace
}  // namespace mien::time_test
