#include "mien/imu/sensor_channel.h"

#include <gtest/gtest.h>

#include <chrono>

namespace mien::imu::sensor_channel_test {
namespace {

DeviceTime at_ms(int ms) {
  return DeviceTime(std::chrono::milliseconds(ms));
}

TEST(SensorChannel, AGapIsCountedOnceWhenPacketsBeginToOvertakeOneAnother) {
  Channel channel{FusionSettings()};
  const Gaps first = channel.take_gaps(0.03, 1, at_ms(1000));
  EXPECT_NEAR(first.sigma_rad, 0.03, 1e-12);
  EXPECT_TRUE(first.tilt_restarted);
  // From here on a tenth of a second ago is asked, when the gap was yet to come.
  EXPECT_EQ(channel.take_gaps(0, 0, at_ms(917)).sigma_rad, 0);
  const Gaps again = channel.take_gaps(0.03, 1, at_ms(1000));
  EXPECT_EQ(again.sigma_rad, 0);
  EXPECT_FALSE(again.tilt_restarted);
  const Gaps next = channel.take_gaps(0.05, 2, at_ms(1017));
  EXPECT_NEAR(next.sigma_rad, 0.04, 1e-12);
  EXPECT_TRUE(next.tilt_restarted);
}

TEST(SensorChannel, AGapThatALatePacketFillsTakesNothingOffTheNextOne) {
  Channel channel{FusionSettings()};
  EXPECT_NEAR(channel.take_gaps(0.03, 1, at_ms(1000)).sigma_rad, 0.03, 1e-12);
  EXPECT_EQ(channel.take_gaps(0, 0, at_ms(1017)).sigma_rad, 0);  // Integrated anew, without it.
  const Gaps next = channel.take_gaps(0.02, 1, at_ms(1034));
  EXPECT_NEAR(next.sigma_rad, 0.02, 1e-12);
  EXPECT_TRUE(next.tilt_restarted);
}

}  // namespace
}  // namespace mien::imu::sensor_channel_test
