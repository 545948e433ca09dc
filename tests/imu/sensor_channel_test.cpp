#include "mien/imu/sensor_channel.h"

#include <gtest/gtest.h>

namespace mien::imu::sensor_channel_test {
namespace {

TEST(SensorChannel, AGapIsCountedOnceWhenPacketsBeginToOvertakeOneAnother) {
  Channel channel{FusionSettings()};
  const Gaps first = channel.take_gaps(0.03, 1);
  EXPECT_NEAR(first.sigma_rad, 0.03, 1e-12);
  EXPECT_TRUE(first.tilt_restarted);
  // From here on a tenth of a second ago is asked, when the gap was yet to come.
  EXPECT_EQ(channel.take_gaps(0, 0).sigma_rad, 0);
  const Gaps again = channel.take_gaps(0.03, 1);
  EXPECT_EQ(again.sigma_rad, 0);
  EXPECT_FALSE(again.tilt_restarted);
  const Gaps next = channel.take_gaps(0.05, 2);
  EXPECT_NEAR(next.sigma_rad, 0.04, 1e-12);
  EXPECT_TRUE(next.tilt_restarted);
}

}  // namespace
}  // namespace mien::imu::sensor_channel_test
