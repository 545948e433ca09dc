#include "mien/session/drift_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "mien/core/units.h"

namespace mien::session::drift_watch_test {
namespace {

using Sensors = std::vector<std::optional<tracker::SensorCertainty>>;

std::optional<DriftWatch::Advice> look(DriftWatch& watch, double at_s, const Sensors& sensors) {
  return watch.add(DeviceTime(from_seconds(at_s)), sensors);
}

Sensors known_to(double degrees) {
  return {tracker::SensorCertainty{.sigma_rad = degrees * kRadPerDeg}, std::nullopt,
          tracker::SensorCertainty{.sigma_rad = degrees * kRadPerDeg}};
}

TEST(DriftWatch, KnowsNothingWithoutSensors) {
  DriftWatch watch;
  for (int second = 0; second < 60; ++second) EXPECT_FALSE(look(watch, second, {std::nullopt, std::nullopt}));
  EXPECT_FALSE(watch.sigma_rad());
  EXPECT_FALSE(watch.advises());
}

TEST(DriftWatch, IsTheRootMeanSquareOfTheSensorsThatAreThere) {
  DriftWatch watch;
  EXPECT_FALSE(look(watch, 0,
                    {tracker::SensorCertainty{.sigma_rad = 0.03}, std::nullopt,
                     tracker::SensorCertainty{.sigma_rad = 0.04}}));
  ASSERT_TRUE(watch.sigma_rad());
  EXPECT_NEAR(*watch.sigma_rad(), std::sqrt((0.0009 + 0.0016) / 2), 1e-12);
}

TEST(DriftWatch, AdvisesOnceAfterTenSecondsAndAgainAfterTenMinutes) {
  DriftWatch watch;
  std::vector<int> told;
  for (int second = 0; second < 1300; ++second)
    if (const auto advice = look(watch, second, known_to(6))) {
      told.push_back(second);
      EXPECT_NEAR(advice->sigma_rad, 6 * kRadPerDeg, 1e-12);
      EXPECT_TRUE(advice->left_out.empty());
    }
  EXPECT_EQ(told, (std::vector<int>{10, 610, 1210}));
  EXPECT_TRUE(watch.advises());
}

TEST(DriftWatch, AMomentIsNoMatter) {
  DriftWatch watch;
  for (int second = 0; second < 120; ++second)
    EXPECT_FALSE(look(watch, second, known_to(second % 10 == 9 ? 4 : 8))) << second;
  EXPECT_FALSE(watch.advises());
}

TEST(DriftWatch, ASensorThatIsLeftOutIsEnough) {
  DriftWatch watch;
  Sensors sensors = known_to(2);
  sensors.push_back(tracker::SensorCertainty{.sigma_rad = 4 * kRadPerDeg, .left_out = true});
  std::optional<DriftWatch::Advice> advice;
  for (int second = 0; second <= 10; ++second) {
    EXPECT_FALSE(advice);
    advice = look(watch, second, sensors);
  }
  ASSERT_TRUE(advice);
  EXPECT_EQ(advice->left_out, std::vector<std::uint16_t>{3});
}

TEST(DriftWatch, BeginsAnewWithACalibration) {
  DriftWatch watch;
  for (int second = 0; second < 60; ++second) static_cast<void>(look(watch, second, known_to(7)));
  EXPECT_TRUE(watch.advises());
  watch.reset();
  EXPECT_FALSE(watch.advises());
  EXPECT_FALSE(look(watch, 60, known_to(2)));
  EXPECT_FALSE(look(watch, 70, known_to(7)));
  EXPECT_TRUE(look(watch, 80, known_to(7))) << "the one before does not keep it quiet";
}

}  // namespace
}  // namespace mien::session::drift_watch_test
