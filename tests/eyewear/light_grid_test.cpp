#include "mien/eyewear/light_grid.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/eyewear/glasses.h"

namespace mien::eyewear::light_grid_test {
namespace {

using test::Glasses;
using test::reading;

constexpr double kSilent = std::numeric_limits<double>::quiet_NaN();
/// The median of ten answers as late as this.
constexpr double kFilterDelay_s = 4.5 / test::kPairs_hz;

TEST(LightGrid, InterpolatesToTheFrameWithoutAmbientLight) {
  test::ClockedGrid grid(test::glasses_rig(2));
  Glasses glasses(2);
  GridLight light;
  double worst = 0;
  const auto slope = [](std::size_t s, double t) { return -2 + (s == 0 ? 0.3 : -0.2) * t; };
  glasses.play(grid, 3, slope, [&](DeviceTime frame) {
    grid.tick(frame, light);
    const double t = to_seconds(frame.time_since_epoch()) - test::kBoard_s;
    ASSERT_EQ(light.present, (std::vector<std::uint8_t>{1, 1})) << t;
    if (t < 0.2) return;
    for (std::size_t s = 0; s < 2; ++s)
      worst = std::max(worst, std::abs(light.log_light[s] - slope(s, t - kFilterDelay_s)));
  });
  EXPECT_LT(worst, 2e-4);
}

TEST(LightGrid, ASensorThatIsSilentIsMissingWithinATenthOfASecondAndComesBack) {
  test::ClockedGrid grid(test::glasses_rig(2));
  Glasses glasses(2);
  GridLight light;
  const auto steady = [](std::size_t, double) { return -1.5; };
  const auto without = [](std::size_t s, double) { return s == 1 ? kSilent : -1.5; };
  glasses.play(grid, 1, steady, [&](DeviceTime frame) { grid.tick(frame, light); });
  EXPECT_EQ(light.present[1], 1);
  glasses.play(grid, 0.09, without, [&](DeviceTime frame) { grid.tick(frame, light); });
  EXPECT_EQ(light.present[1], 1) << "its light is held for a moment";
  EXPECT_NEAR(light.log_light[1], -1.5, 1e-6);
  glasses.play(grid, 0.05, without, [&](DeviceTime frame) { grid.tick(frame, light); });
  EXPECT_EQ(light.present[0], 1);
  EXPECT_EQ(light.present[1], 0);
  glasses.play(grid, 0.05, steady, [&](DeviceTime frame) { grid.tick(frame, light); });
  EXPECT_EQ(light.present[1], 1);
}

TEST(LightGrid, HoldsWhatIsDimmerThanAStepOfTheConverter) {
  test::ClockedGrid grid(test::glasses_rig(1));
  GridLight light;
  for (int i = 0; i < 200; ++i) {
    const double t = i / test::kPairs_hz;
    grid.add(HostTime(from_seconds(t)), reading(0, test::kBoard_s + t, 0.2, 0.2 + 0.001 * (i % 3)));
  }
  grid.tick(Glasses::at(0.8), light);
  EXPECT_EQ(light.present[0], 1);
  EXPECT_DOUBLE_EQ(light.log_light[0], std::log(LightGrid::kDimmest));
}

TEST(LightGrid, OtherLightThatFillsTheRangeBlinds) {
  test::ClockedGrid grid(test::glasses_rig(1));
  GridLight light;
  for (int i = 0; i < 200; ++i) {
    const double t = i / test::kPairs_hz;
    const bool sun = t > 0.5;
    grid.add(HostTime(from_seconds(t)), reading(0, test::kBoard_s + t, sun ? 1 : 0.4, sun ? 1 : 0.1));
    if (i == 100) {
      grid.tick(Glasses::at(t), light);
      EXPECT_EQ(light.present[0], 1);
      EXPECT_EQ(light.saturated[0], 0);
    }
  }
  grid.tick(Glasses::at(199 / test::kPairs_hz), light);
  EXPECT_EQ(light.present[0], 0);
  EXPECT_EQ(light.saturated[0], 1);
}

TEST(LightGrid, DoubledAndOvertakenSamplesChangeNothingAndARestartBeginsAnew) {
  test::ClockedGrid one(test::glasses_rig(1)), other(test::glasses_rig(1));
  GridLight a, b;
  const auto sample = [](int i) {
    const double t = i / test::kPairs_hz;
    return reading(0, test::kBoard_s + t, 0.3 + 0.001 * (i % 50), 0.05);
  };
  for (int i = 0; i < 300; ++i) {
    const HostTime arrival(from_seconds(i / test::kPairs_hz + 0.003));
    one.add(arrival, sample(i));
    other.add(arrival, sample(i));
    if (i > 10 && i % 7 == 0) other.add(arrival, sample(i));
    if (i > 10 && i % 11 == 0) other.add(arrival, sample(i - 3));
  }
  one.tick(Glasses::at(1.29), a);
  other.tick(Glasses::at(1.29), b);
  EXPECT_EQ(a.present[0], 1);
  EXPECT_EQ(a.log_light, b.log_light);

  // The board begins anew at 0: the line goes on, and so does the light.
  for (int i = 0; i < 100; ++i)
    one.add(HostTime(from_seconds(1.6 + i / test::kPairs_hz)), reading(0, i / test::kPairs_hz, 0.25, 0.05));
  one.tick(Glasses::at(1.6 + 98 / test::kPairs_hz), a);
  EXPECT_EQ(a.present[0], 1);
  EXPECT_NEAR(a.log_light[0], std::log(0.2), 1e-4);

  one.forget(0);
  one.tick(Glasses::at(2.03), a);
  EXPECT_EQ(a.present[0], 0);
}

TEST(LightGrid, OnlyPhotoReflectiveSensorsCount) {
  sensor::Rig rig = test::glasses_rig(3);
  rig.sensors[1].kind = "imu";
  EXPECT_EQ(photo_sensors(rig), (std::vector<std::uint16_t>{0, 2}));
  test::ClockedGrid grid(rig);
  GridLight light;
  Glasses glasses(3);
  glasses.play(
      grid, 0.5, [](std::size_t s, double) { return -1.0 - static_cast<double>(s); },
      [&](DeviceTime frame) { grid.tick(frame, light); });
  ASSERT_EQ(light.present, (std::vector<std::uint8_t>{1, 1}));
  EXPECT_NEAR(light.log_light[1], -3, 1e-5);
}

}  // namespace
}  // namespace mien::eyewear::light_grid_test
