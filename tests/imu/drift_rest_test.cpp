#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "tests/imu/drifting_wearer.h"

namespace mien::imu::drift_rest_test {
namespace {

using test::calibrated;
using test::kFrame_s;
using test::kSensors;
using test::Wearer;

/// The face at rest, and the filter's correction by it. `missing`: this sensor is not measured.
void rest(const Wearer& wearer, DriftFilter& filter, std::optional<std::size_t> missing = {}) {
  std::array<std::optional<Vec3>, kSensors> turns;
  for (std::size_t i = 0; i < kSensors; ++i)
    if (i != missing) turns[i] = wearer.turn_error(filter, i);
  const std::array<double, kSensors> sigma_rad = {kRadPerDeg, kRadPerDeg, kRadPerDeg, kRadPerDeg};
  filter.observe_rest(turns, sigma_rad, wearer.up());
}

/// The rotation's error with the head turned by this from where it rested.
double error_deg(Wearer wearer, const DriftFilter& filter, std::size_t i, double after_s) {
  wearer.t_s += after_s;
  return kDegPerRad * wearer.turn_error(filter, i).norm();
}

TEST(DriftFilterAtRest, CorrectsASensorThatWasPutOnAgain) {
  for (const std::uint64_t seed : {71, 72, 73})
    for (const double off_deg : {10.0, 25.0, 40.0}) {
      Wearer wearer(seed);
      DriftFilter filter = calibrated();
      wearer.wear(filter, 300);
      const std::array<double, 3> before = {error_deg(wearer, filter, 0, 0), error_deg(wearer, filter, 2, 0),
                                            error_deg(wearer, filter, 3, 0)};
      wearer.creep_rad[1] = wearer.random.normal_vector(1).normalized() * off_deg * kRadPerDeg;
      EXPECT_GT(error_deg(wearer, filter, 1, 0), 0.7 * off_deg);
      rest(wearer, filter);
      EXPECT_LT(error_deg(wearer, filter, 1, 0), 0.3) << seed << " " << off_deg;
      // What its heading took of it shows once the head nods.
      EXPECT_LT(error_deg(wearer, filter, 1, 1.7), 0.1 * off_deg) << seed << " " << off_deg;
      EXPECT_LT(error_deg(wearer, filter, 0, 0), std::max(1.0, before[0])) << "the others are left";
      EXPECT_LT(error_deg(wearer, filter, 2, 0), std::max(1.0, before[1]));
      EXPECT_LT(error_deg(wearer, filter, 3, 0), std::max(1.0, before[2]));
      EXPECT_TRUE(filter.sound());
      EXPECT_EQ(filter.faults(), 0);
      const Mat3 covariance = filter.rotation_covariance(1, wearer.up());
      EXPECT_LT(std::sqrt(covariance.trace()), 2 * kRadPerDeg) << "and it is known again";
      // It stays where it is.
      wearer.wear(filter, 600);
      EXPECT_LT(error_deg(wearer, filter, 1, 0), 3) << seed << " " << off_deg;
    }
}

TEST(DriftFilterAtRest, CorrectsHeadingsThatAreUncertain) {
  for (const double off_deg : {20.0, -80.0, 170.0}) {
    Wearer wearer(74);
    DriftFilter filter = calibrated();
    wearer.wear(filter, 300);
    wearer.creep_rad[1] = filter.creep_rad(1) + Vec3(-1, 0.5, 1) * kRadPerDeg;
    filter.move_to(1, off_deg * kRadPerDeg, std::abs(off_deg) * kRadPerDeg);
    wearer.creep_rad[2] = Vec3(0, 15, 20) * kRadPerDeg;
    rest(wearer, filter);
    EXPECT_LT(error_deg(wearer, filter, 1, 0), 1) << off_deg;
    EXPECT_LT(error_deg(wearer, filter, 2, 0), 0.3) << off_deg;
    EXPECT_LT(kDegPerRad * std::abs(wearer.heading_error(filter, 1)), 3.5) << off_deg;
    EXPECT_LT(error_deg(wearer, filter, 1, 1.7), 1.5) << off_deg;
  }
}

TEST(DriftFilterAtRest, FindsAnEarSensorThatMoved) {
  Wearer wearer(75);
  DriftFilter filter = calibrated();
  wearer.wear(filter, 60);
  wearer.ear_creep_rad = Vec3(6, -4, 12) * kRadPerDeg;
  wearer.creep_rad[3] = Vec3(20, 5, -5) * kRadPerDeg;
  rest(wearer, filter, 2);
  for (const std::size_t i : {0, 1, 3}) EXPECT_LT(error_deg(wearer, filter, i, 0), 0.5) << i;
  EXPECT_LT((filter.ear_creep_rad() - wearer.ear_creep_rad).norm(), 2 * kRadPerDeg);
  EXPECT_LT(error_deg(wearer, filter, 2, 0), 2.5) << "a sensor that was not measured is corrected by it too";
}

TEST(DriftFilterAtRest, WeighsItsPrior) {
  // Of a wearer who does not rest quite as at the calibration: a degree is no drift of a fresh calibration.
  DriftFilter filter = calibrated();
  std::array<std::optional<Vec3>, kSensors> turns;
  turns[1] = Vec3(1, 0, 0) * kRadPerDeg;
  const std::array<double, kSensors> sigma_rad = {kRadPerDeg, kRadPerDeg, kRadPerDeg, kRadPerDeg};
  filter.observe_rest(turns, sigma_rad, Vec3::UnitY());
  EXPECT_LT(filter.creep_rad(1).norm(), 0.01 * kRadPerDeg);
  // After a minute without skin, creep of the adhesive and the ear sensor's are known to 0.5 degrees each.
  for (int i = 0; i < 60 * 30; ++i) filter.predict(kFrame_s);
  const double creep_deg2 = 60 * std::pow(kDegPerRad * DriftSettings().creep_walk, 2);
  filter.observe_rest(turns, sigma_rad, Vec3::UnitY());
  EXPECT_NEAR(kDegPerRad * filter.creep_rad(1).x(), creep_deg2 / (2 * creep_deg2 + 1), 0.01);
  EXPECT_EQ(filter.creep_rad(0), Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace mien::imu::drift_rest_test
