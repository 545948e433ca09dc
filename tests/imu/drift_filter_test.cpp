#include "mien/imu/drift_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/imu/drifting_wearer.h"

namespace mien::imu::drift_filter_test {
namespace {

using test::calibrated;
using test::kAxes;
using test::kFrame_s;
using test::kMuscles;
using test::kNames;
using test::kSensors;
using test::Skin;
using test::Wearer;

/// Everything that a filter shows, as bits.
std::vector<double> shown(const DriftFilter& filter, const Vec3& up) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < kSensors; ++i) {
    numbers.push_back(filter.heading_rad(i));
    numbers.push_back(filter.heading_sigma_rad(i));
    for (const double axis : filter.creep_rad(i)) numbers.push_back(axis);
    const Mat3 covariance = filter.rotation_covariance(i, up);
    for (const double entry : covariance.reshaped()) numbers.push_back(entry);
  }
  for (const double axis : filter.ear_creep_rad()) numbers.push_back(axis);
  return numbers;
}

TEST(DriftFilter, FollowsHeadingsThatDrift) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Wearer wearer(seed);
    DriftFilter filter = calibrated();
    double worst_rad = 0;
    wearer.wear(filter, 20 * 60, [&] {
      wearer.heading_rad[0] += 0.05 * kRadPerDeg * kFrame_s;
      wearer.heading_rad[2] -= 0.03 * kRadPerDeg * kFrame_s;
      for (std::size_t i = 0; i < kSensors; ++i)
        worst_rad = std::max(worst_rad, std::abs(wearer.heading_error(filter, i)));
    });
    ASSERT_GT(wearer.heading_rad[0], 59 * kRadPerDeg);
    EXPECT_LT(worst_rad, 2 * kRadPerDeg) << seed;
    EXPECT_LT(std::abs(wearer.heading_error(filter, 0)), 0.6 * kRadPerDeg) << seed;
  }
}

/// Six degrees in an hour.
const Vec3 kCreep_rad_s = 6 * kRadPerDeg / 3600 * Vec3(2, -1, 2).normalized();

TEST(DriftFilter, FollowsTheCreepOfOneSensor) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Wearer wearer(seed);
    DriftFilter filter = calibrated();
    wearer.wear(filter, 3600, [&] { wearer.creep_rad[1] += kFrame_s * kCreep_rad_s; });
    for (std::size_t i = 0; i < kSensors; ++i)
      EXPECT_LT(wearer.turn_error(filter, i).norm(), (i == 1 ? 2.5 : 1.5) * kRadPerDeg) << seed << " " << i;
    for (const std::size_t i : {0, 2, 3})
      EXPECT_GT(filter.creep_rad(1).norm(), 1.5 * filter.creep_rad(i).norm()) << seed << " " << i;
  }
}

TEST(DriftFilter, FollowsTheCreepOfTheEarSensor) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    Wearer wearer(seed);
    DriftFilter filter = calibrated();
    wearer.wear(filter, 3600, [&] { wearer.ear_creep_rad += kFrame_s * kCreep_rad_s; });
    // By the prior a share of one in five is the face sensors' own, all alike: 1.2 degrees.
    EXPECT_LT((wearer.ear_creep_rad - filter.ear_creep_rad()).norm(), 2.3 * kRadPerDeg) << seed;
    for (std::size_t i = 0; i < kSensors; ++i) {
      EXPECT_LT(wearer.turn_error(filter, i).norm(), 2.1 * kRadPerDeg) << seed << " " << i;
      EXPECT_LT(filter.creep_rad(i).norm(), 2.4 * kRadPerDeg) << seed << " " << i;
    }
  }
}

/// After ten usual minutes an expression along one muscle, 2.5 times the usual, for two minutes: which share
/// of it is left.
double kept_of_expression(const DriftSettings& settings, Eigen::Index muscle, double sign) {
  Wearer wearer(4 + static_cast<std::uint64_t>(muscle));
  DriftFilter filter = calibrated(Skin().people, settings);
  wearer.wear(filter, 600);
  wearer.holds = true;
  wearer.goal = 2.5 * sign * Eigen::Vector3d::Unit(muscle);
  wearer.wear(filter, 120);
  Eigen::VectorXd turn(kAxes);
  for (std::size_t i = 0; i < kSensors; ++i)
    turn.segment<3>(static_cast<Eigen::Index>(3 * i)) = wearer.estimated_turn(filter, i, wearer.skin_of(i));
  const Eigen::VectorXd expression = wearer.skin_rad - wearer.mean_rad;
  return (turn - wearer.mean_rad).dot(expression) / expression.squaredNorm();
}

TEST(DriftFilter, KeepsAnExpressionThatIsHeld) {
  DriftSettings eager;
  eager.correlation_s = 2;
  eager.gate = 100;
  eager.shift.gate = 0;
  for (Eigen::Index muscle = 0; muscle < kMuscles; ++muscle)
    for (const double sign : {1.0, -1.0}) {
      const double kept = kept_of_expression({}, muscle, sign);
      EXPECT_GT(kept, 0.8) << muscle;
      EXPECT_LT(kept, 1.1) << muscle;
      EXPECT_LT(kept_of_expression(eager, muscle, sign), 0.7) << muscle;
    }
}

TEST(DriftFilter, ErrorsAreAsLargeAsTheCovariance) {
  // Of this wearer's skin, which forgets its motion within seconds.
  DriftSettings settings;
  settings.correlation_s = settings.first_correlation_s = 5;
  double sum = 0;
  constexpr int kSeeds = 8;
  for (std::uint64_t seed = 11; seed < 11 + kSeeds; ++seed) {
    Wearer wearer(seed);
    DriftFilter filter = calibrated(Skin().people, settings);
    Random random(seed + 100);
    std::array<double, kSensors> rate_rad_s{};
    for (std::size_t i = 0; i < kSensors; ++i) {
      rate_rad_s[i] = random.normal(0, settings.rate_sigma_rad_s);
      wearer.heading_rad[i] = random.normal(0, 0.5 * kRadPerDeg);
    }
    // Truth walks as the filter has it: errors' squares by its covariance, an axis, once a second.
    const double root = std::sqrt(kFrame_s);
    double squares = 0;
    int frame = 0, counted = 0;
    wearer.wear(filter, 1800, [&] {
      const double ear_rate = random.normal(), ear = random.normal();
      for (std::size_t i = 0; i < kSensors; ++i) {
        rate_rad_s[i] += settings.rate_walk * root * std::sqrt(0.5) * (ear_rate + random.normal());
        wearer.heading_rad[i] += rate_rad_s[i] * kFrame_s + root * (settings.heading_walk * random.normal() +
                                                                    settings.common_walk * ear);
        wearer.creep_rad[i] += random.normal_vector(settings.creep_walk * root);
      }
      wearer.ear_creep_rad += random.normal_vector(settings.creep_walk * root);
      if (++frame % 30 != 0) return;
      for (std::size_t i = 0; i < kSensors; ++i) {
        const Vec3 error = wearer.turn_error(filter, i);
        squares += error.dot(filter.rotation_covariance(i, wearer.up()).ldlt().solve(error)) / 3;
        ++counted;
      }
    });
    const double mean = squares / counted;
    EXPECT_GT(mean, 0.4) << seed;
    EXPECT_LT(mean, 2.0) << seed;
    sum += mean;
    EXPECT_LT(std::sqrt(filter.rotation_covariance(0, wearer.up()).trace()), 3 * kRadPerDeg) << seed;
  }
  EXPECT_NEAR(sum / kSeeds, 1, 0.3);
}

TEST(DriftFilter, KeepsACovarianceThroughAMillionFrames) {
  // Nine hours in which sensors vanish and return, boards restart, the head nods, and boards are tilted.
  Wearer wearer(21);
  DriftFilter filter = calibrated();
  Random random(22);
  for (int i = 0; i < 1'000'000; ++i) {
    if (random.chance(1e-3)) wearer.present[random.below(kSensors)] = random.chance(0.6);
    const std::size_t sensor = random.below(kSensors);
    if (random.chance(1e-4)) filter.inflate(sensor, 8 * kRadPerDeg);
    if (random.chance(1e-4))
      filter.move_to(sensor, wearer.heading_rad[sensor] + random.normal(0, 5 * kRadPerDeg), 5 * kRadPerDeg);
    if (random.chance(1e-3))
      filter.add_nod(sensor, {.error_rad = wearer.heading_error(filter, sensor) + random.normal(0, 0.01),
                              .sigma_rad = 0.01});
    wearer.heading_rad[sensor] += random.normal(0, 5e-4);
    wearer.add_to(filter, i % 3000 < 200 ? 0.01 : 0);
    if (i % 500 == 0) {
      ASSERT_TRUE(filter.sound()) << i;
    }
  }
  EXPECT_EQ(filter.faults(), 0);
  wearer.present.fill(true);
  wearer.wear(filter, 120);
  EXPECT_TRUE(filter.sound());
  for (std::size_t i = 0; i < kSensors; ++i) {
    EXPECT_GT(filter.heading_sigma_rad(i), 0.05 * kRadPerDeg);
    EXPECT_LT(filter.heading_sigma_rad(i), 4 * kRadPerDeg);
    EXPECT_LT(std::abs(wearer.heading_error(filter, i)), 4 * filter.heading_sigma_rad(i)) << i;
  }
}

TEST(DriftFilter, ASensorThatWasMissingComesBack) {
  for (const std::uint64_t seed : {31, 32, 33}) {
    Wearer wearer(seed);
    DriftFilter filter = calibrated();
    double others_rad = 0;
    const auto drift = [&] {
      for (double& heading : wearer.heading_rad) heading += 0.01 * kRadPerDeg * kFrame_s;
      for (const std::size_t i : {0, 1, 3})
        others_rad = std::max(others_rad, wearer.turn_error(filter, i).norm());
    };
    wearer.wear(filter, 600, drift);
    wearer.present[2] = false;
    wearer.wear(filter, 1200, drift);
    EXPECT_GT(filter.heading_sigma_rad(2), 20 * kRadPerDeg);
    // Its bias has changed meanwhile.
    wearer.heading_rad[2] += 15 * kRadPerDeg;
    wearer.present[2] = true;
    // Nothing converges from anywhere: the filter is linear about its estimate, and has to be brought near.
    filter.move_to(2, wearer.heading_rad[2] - 12 * kRadPerDeg, 10 * kRadPerDeg);
    wearer.wear(filter, 60, drift);
    double worst_rad = 0;
    wearer.wear(filter, 600, [&] {
      drift();
      worst_rad = std::max(worst_rad, wearer.turn_error(filter, 2).norm());
    });
    EXPECT_LT(worst_rad, 1.5 * kRadPerDeg) << seed;
    EXPECT_LT(filter.heading_sigma_rad(2), 2 * kRadPerDeg) << seed;
    EXPECT_LT(others_rad, 2.2 * kRadPerDeg) << seed;
  }
}

TEST(DriftFilter, GapsThatComeOftenAreFollowed) {
  // A tenth of the packets is lost in bursts of a sixth of a second: each hides a turn about the vertical, of
  // which one in ten is 2.4 times as large.
  for (const std::uint64_t seed : {31, 32, 33}) {
    Wearer wearer(seed);
    DriftFilter filter = calibrated();
    std::array<double, kSensors> back_s{};
    double squares_rad2 = 0, frames = 0;
    wearer.wear(filter, 180, [&] {
      for (std::size_t i = 0; i < kSensors; ++i) {
        if (!wearer.present[i] && wearer.t_s >= back_s[i]) {
          const double hidden_rad = (wearer.random.chance(0.1) ? 6 : 2.5) * kRadPerDeg;
          wearer.heading_rad[i] += hidden_rad * wearer.random.normal();
          filter.inflate(i, 3 * kRadPerDeg);
          wearer.present[i] = true;
        } else if (wearer.present[i] && wearer.random.chance(kFrame_s / 1.5)) {
          back_s[i] = wearer.t_s + 1.0 / 6;
          wearer.present[i] = false;
        }
        if (!wearer.present[i] || wearer.t_s < 20) continue;
        const double error_rad = wearer.heading_error(filter, i);
        squares_rad2 += error_rad * error_rad;
        ++frames;
      }
    });
    EXPECT_LT(std::sqrt(squares_rad2 / frames), 2.5 * kRadPerDeg) << seed;
  }
}

/// Error of a sensor five minutes after it came back, turned on the skin, from 40 s of absence, degrees.
double error_after_putting_on_deg(std::uint64_t seed, const DriftSettings& settings) {
  Wearer wearer(seed);
  DriftFilter filter = calibrated(Skin().people, settings);
  wearer.wear(filter, 600);
  wearer.present[2] = false;
  wearer.wear(filter, 40);
  wearer.creep_rad[2] = Vec3(25, 5, -5) * kRadPerDeg;
  wearer.present[2] = true;
  wearer.wear(filter, 300);
  return wearer.turn_error(filter, 2).norm() / kRadPerDeg;
}

TEST(DriftFilter, ASensorThatWasPutOnAgainIsFound) {
  DriftSettings never;
  never.taken_off_s = 1e9;
  for (const std::uint64_t seed : {34, 35, 36}) {
    EXPECT_LT(error_after_putting_on_deg(seed, {}), 3) << seed;
    EXPECT_GT(error_after_putting_on_deg(seed, never), 10) << seed;
  }
}

/// Standard deviation of a sensor's rotation before 40 s of absence, and at its first frame after it,
/// degrees.
std::array<double, 2> sigma_around_absence_deg(bool of_all) {
  Wearer wearer(37);
  DriftFilter filter = calibrated();
  wearer.wear(filter, 600);
  const auto sigma_deg = [&] {
    return kDegPerRad * std::sqrt(filter.rotation_covariance(2, wearer.up()).trace());
  };
  const double before_deg = sigma_deg();
  for (std::size_t i = 0; i < kSensors; ++i) wearer.present[i] = !of_all && i != 2;
  wearer.wear(filter, 40);
  wearer.present.fill(true);
  wearer.wear(filter, kFrame_s);
  return {before_deg, sigma_deg()};
}

TEST(DriftFilter, SensorsThatWereAllAbsentKeepTheirCreep) {
  const auto [before_deg, after_deg] = sigma_around_absence_deg(true);
  EXPECT_LT(after_deg, before_deg + 3);
  EXPECT_GT(sigma_around_absence_deg(false)[1], before_deg + 20);
}

TEST(DriftFilter, GrowsUncertainWithoutMeasurements) {
  const DriftSettings settings;
  DriftFilter filter = calibrated();
  const Vec3 up = Vec3(0.2, 1, -0.3).normalized();
  double last_rad = filter.heading_sigma_rad(0), t_s = 0;
  EXPECT_NEAR(last_rad, 0.5 * kRadPerDeg, 1e-12);
  while (t_s < 60) {
    filter.predict(kFrame_s);
    t_s += kFrame_s;
    EXPECT_GT(filter.heading_sigma_rad(0), last_rad);
    last_rad = filter.heading_sigma_rad(0);
  }
  const auto square = [](double number) { return number * number; };
  const double expected_rad2 =
      square(0.5 * kRadPerDeg) + (square(settings.heading_walk) + square(settings.common_walk)) * t_s +
      square(settings.rate_sigma_rad_s * t_s) + square(settings.rate_walk) * t_s * t_s * t_s / 3;
  EXPECT_NEAR(last_rad, std::sqrt(expected_rad2), 1e-3 * last_rad);
  // Creep of its adhesive and of the ear sensor's.
  const Mat3 expected =
      expected_rad2 * up * up.transpose() + 2 * square(settings.creep_walk) * t_s * Mat3::Identity();
  EXPECT_LT((filter.rotation_covariance(0, up) - expected).norm(), 2e-3 * expected.norm());
  EXPECT_EQ(filter.heading_rad(0), 0);
  for (int i = 0; i < 3600 * 24; ++i) filter.predict(1);
  EXPECT_EQ(filter.heading_sigma_rad(0), std::numbers::pi) << "no heading is less certain than any";
  EXPECT_TRUE(filter.sound());
}

TEST(DriftFilter, WorksWithSensorsThatTheSkinTableLacks) {
  sensor::SkinMotion others = Skin().people;
  others.sensors[3] = "e";
  for (const std::optional<sensor::SkinMotion>& people :
       {std::optional<sensor::SkinMotion>(), std::optional<sensor::SkinMotion>(others)})
    for (const std::uint64_t seed : {41, 42, 43}) {
      Wearer wearer(seed);
      DriftFilter filter = calibrated(people);
      double worst_rad = 0;
      wearer.wear(filter, 20 * 60, [&] {
        wearer.heading_rad[0] += 0.05 * kRadPerDeg * kFrame_s;
        wearer.heading_rad[3] += 0.05 * kRadPerDeg * kFrame_s;
        worst_rad = std::max({worst_rad, std::abs(wearer.heading_error(filter, 0)),
                              std::abs(wearer.heading_error(filter, 3))});
      });
      EXPECT_LT(worst_rad, 4 * kRadPerDeg) << seed;
      for (std::size_t i = 0; i < kSensors; ++i) {
        EXPECT_LT(wearer.turn_error(filter, i).norm(), 3.3 * kRadPerDeg) << seed << " " << i;
      }
    }
}

TEST(DriftFilter, ANodCorrectsItsHeading) {
  DriftFilter filter = calibrated();
  filter.move_to(1, 5 * kRadPerDeg, 10 * kRadPerDeg);
  // Optimal weights of the two: 100 to 1.
  filter.add_nod(1, {.error_rad = 5 * kRadPerDeg, .sigma_rad = 1 * kRadPerDeg});
  EXPECT_NEAR(filter.heading_rad(1), 5 * kRadPerDeg / 101, 1e-12);
  EXPECT_NEAR(filter.heading_sigma_rad(1), std::sqrt(100 / 101.0) * kRadPerDeg, 1e-12);
  EXPECT_EQ(filter.heading_rad(0), 0);
  EXPECT_NEAR(filter.heading_sigma_rad(0), 0.5 * kRadPerDeg, 1e-12);
  EXPECT_EQ(filter.creep_rad(1), Vec3(Vec3::Zero()));
}

TEST(DriftFilter, NodsSeparateAHeadingFromItsRate) {
  DriftFilter filter = calibrated();
  double truth_rad = 0;
  for (int second = 0; second < 300; ++second) {
    truth_rad += 0.08 * kRadPerDeg;
    filter.predict(1);
    filter.add_nod(0, {.error_rad = filter.heading_rad(0) - truth_rad, .sigma_rad = 0.5 * kRadPerDeg});
  }
  const double before_rad = filter.heading_rad(0);
  for (int i = 0; i < 30; ++i) filter.predict(1);
  EXPECT_NEAR(filter.heading_rad(0) - before_rad, 30 * 0.08 * kRadPerDeg, 0.3 * kRadPerDeg);
}

TEST(DriftFilter, AMoveKeepsCreepAndWrapsTheHeading) {
  Wearer wearer(51);
  DriftFilter filter = calibrated();
  wearer.wear(filter, 600, [&] { wearer.creep_rad[1] += 5 * kFrame_s * kCreep_rad_s; });
  const Vec3 creep_rad = filter.creep_rad(1), ear_creep_rad = filter.ear_creep_rad();
  EXPECT_GT(creep_rad.norm(), 1 * kRadPerDeg);
  filter.move_to(1, 4, 3 * kRadPerDeg);
  EXPECT_NEAR(filter.heading_rad(1), 4 - 2 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(filter.heading_sigma_rad(1), 3 * kRadPerDeg, 1e-12);
  EXPECT_EQ(filter.creep_rad(1), creep_rad);
  EXPECT_EQ(filter.ear_creep_rad(), ear_creep_rad);
  filter.inflate(1, 4 * kRadPerDeg);
  EXPECT_NEAR(filter.heading_sigma_rad(1), 5 * kRadPerDeg, 1e-12);
  EXPECT_TRUE(filter.sound());
  // Its rate is unknown again: it stays where it was put.
  filter.predict(10);
  EXPECT_NEAR(filter.heading_rad(1), 4 - 2 * std::numbers::pi, 1e-12);
}

TEST(DriftFilter, ATiltedFaceWeighsLess) {
  const auto left_rad = [](double tilt_rad) {
    Wearer wearer(52);
    DriftFilter filter = calibrated();
    for (std::size_t i = 0; i < kSensors; ++i) filter.move_to(i, i == 1 ? 4 * kRadPerDeg : 0, 3 * kRadPerDeg);
    for (int i = 0; i < 30 * 20; ++i) wearer.add_to(filter, tilt_rad * tilt_rad);
    return std::abs(wearer.heading_error(filter, 1));
  };
  EXPECT_LT(left_rad(0), 2 * kRadPerDeg);
  EXPECT_GT(left_rad(40 * kRadPerDeg), 2 * left_rad(0));
}

TEST(DriftFilter, ACopyContinuesWithTheSameBits) {
  Wearer wearer(61);
  DriftFilter filter = calibrated();
  const auto drift_of = [](Wearer& of) {
    return [&of] {
      of.heading_rad[0] += 0.02 * kRadPerDeg * kFrame_s;
      of.present[3] = std::fmod(of.t_s, 50) > 10;
    };
  };
  wearer.wear(filter, 100, drift_of(wearer));
  Wearer other_wearer = wearer;
  DriftFilter other = filter;
  const std::vector<double> before = shown(filter, Vec3::UnitY());
  wearer.wear(filter, 100, drift_of(wearer));
  EXPECT_EQ(shown(other, Vec3::UnitY()), before) << "the copy stands by itself";
  EXPECT_NE(shown(filter, Vec3::UnitY()), before);
  other_wearer.wear(other, 100, drift_of(other_wearer));
  EXPECT_EQ(shown(other, Vec3::UnitY()), shown(filter, Vec3::UnitY()));
}

TEST(DriftFilter, StartsAnewAsIfItWereNew) {
  DriftFilter filter = calibrated();
  Wearer before(62);  // A number of frames that is no multiple of the directions'.
  before.present[1] = false;
  before.wear(filter, 700.7, [&] { before.creep_rad[0] += 5 * kFrame_s * kCreep_rad_s; });
  filter.inflate(2, 3 * kRadPerDeg);
  filter.start();
  for (std::size_t i = 0; i < kSensors; ++i) filter.move_to(i, 0, 0.5 * kRadPerDeg);
  DriftFilter fresh = calibrated();
  EXPECT_EQ(shown(filter, Vec3::UnitY()), shown(fresh, Vec3::UnitY()));
  Wearer wearer(63), same = wearer;
  wearer.wear(filter, 60);
  same.wear(fresh, 60);
  EXPECT_EQ(shown(filter, Vec3::UnitY()), shown(fresh, Vec3::UnitY()));
}

TEST(DriftFilter, WithoutSensorsItDoesNothing) {
  DriftFilter filter({}, Skin().people, {});
  filter.start();
  for (int i = 0; i < 1000; ++i) {
    filter.predict(kFrame_s);
    filter.add_skin(kFrame_s, {}, {}, Vec3::UnitY());
  }
  EXPECT_TRUE(filter.sound());
  EXPECT_EQ(filter.faults(), 0);
  EXPECT_EQ(filter.ear_creep_rad(), Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace mien::imu::drift_filter_test
