#include "mien/imu/walk_scale.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "mien/core/random.h"
#include "tests/imu/drifting_wearer.h"

namespace mien::imu::walk_scale_test {
namespace {

constexpr std::size_t kCount = 11;

/// The factor after hours of independent corrections once a second, whose squares are `ratio` times what is
/// expected of each, of the first `odd` sensors a hundred times that.
double factor_after(double hours, double ratio, std::size_t odd = 0) {
  Random random(7);
  WalkScale scale(kCount, 60, 0.5);
  double product = 1;
  for (int second = 0; second < std::lround(3600 * hours); ++second) {
    for (std::size_t i = 0; i < kCount; ++i) {
      const double size = std::sqrt(ratio / 3 * (i < odd ? 100 : 1));
      scale.add(i, size * random.normal_vector(1), 1);
    }
    product *= scale.advance(1);
  }
  EXPECT_NEAR(product, scale.variance_factor(), 1e-9);
  return scale.variance_factor();
}

TEST(WalkScale, IsOneWhereCorrectionsAreAsUsual) {
  for (const double ratio : {0.05, 0.2, 0.3}) EXPECT_LT(factor_after(1, ratio), 1.3) << ratio;
}

TEST(WalkScale, GrowsWhereMostSensorsAreCorrectedMore) {
  EXPECT_GT(factor_after(0.2, 2), 3);
  EXPECT_LE(factor_after(1, 50), 16);
}

TEST(WalkScale, AFewSensorsDoNotMoveIt) {
  EXPECT_LT(factor_after(1, 0.3, 4), 1.6);
}

TEST(WalkScale, TwoSensorsTellNothing) {
  WalkScale scale(kCount, 60, 0.5);
  for (int n = 0; n < 600; ++n) {
    scale.add(3, Vec3(1, 1, 1), 0.01);
    scale.add(4, Vec3(1, 1, 1), 0.01);
    EXPECT_EQ(scale.advance(1), 1);
  }
}

TEST(WalkScale, WithoutCorrectionsItStays) {
  WalkScale scale(kCount, 60, 0.5);
  for (int n = 0; n < 1000; ++n) EXPECT_EQ(scale.advance(1), 1);
  for (std::size_t i = 0; i < kCount; ++i) scale.add(i, Vec3(1, 1, 1), 0.1);
  for (int n = 0; n < 200; ++n) (void)scale.advance(1);
  EXPECT_GT(scale.variance_factor(), 1.5);
  scale.start();
  EXPECT_EQ(scale.variance_factor(), 1);
}

/// RMS error of three wearers' rotations over the second half of an hour, degrees. `scaled`: how many times
/// the usual walks of creep and of headings' rates the sensors have, and the filter's settings expect.
struct Scaled {
  double creep = 1, rate = 1;
};
double error_deg(const Scaled& sensors, const Scaled& settings) {
  const DriftSettings usual;
  DriftSettings expected;
  expected.creep_walk *= settings.creep;
  expected.rate_walk *= settings.rate;
  double squares = 0, count = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    test::Wearer wearer(seed);
    Random random(seed + 10);
    DriftFilter filter = test::calibrated(test::Skin().people, expected);
    std::array<double, test::kSensors> rate_rad_s{};
    const double root_s = std::sqrt(test::kFrame_s);
    wearer.wear(filter, 3600, [&] {
      for (std::size_t i = 0; i < test::kSensors; ++i) {
        wearer.creep_rad[i] += random.normal_vector(sensors.creep * usual.creep_walk * root_s);
        rate_rad_s[i] += random.normal(0, sensors.rate * usual.rate_walk * root_s);
        wearer.heading_rad[i] += rate_rad_s[i] * test::kFrame_s;
      }
      if (wearer.t_s < 1800) return;
      for (std::size_t i = 0; i < test::kSensors; ++i, ++count)
        squares += wearer.turn_error(filter, i).squaredNorm();
    });
    for (std::size_t i = 0; i < test::kSensors; ++i)
      EXPECT_LT(std::sqrt(filter.rotation_covariance(i, wearer.up()).trace()), 12 * kRadPerDeg) << seed;
  }
  return kDegPerRad * std::sqrt(squares / count);
}

TEST(WalkScale, SoftAdhesivesAreFollowedNearlyAsIfTheSettingsExpectedThem) {
  EXPECT_LT(error_deg({.creep = 3}, {}), 1.5 * error_deg({.creep = 3}, {.creep = 3}));
}

TEST(WalkScale, CheapGyroscopesAreFollowedNearlyAsIfTheSettingsExpectedThem) {
  EXPECT_LT(error_deg({.rate = 4}, {}), 1.6 * error_deg({.rate = 4}, {.rate = 4}));
}

}  // namespace
}  // namespace mien::imu::walk_scale_test
