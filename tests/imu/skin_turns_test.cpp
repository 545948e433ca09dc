#include "mien/imu/skin_turns.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <string>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/units.h"

namespace mien::imu::skin_turns_test {
namespace {

constexpr int kSensors = 4;
const std::vector<std::string> kNames = {"a", "b", "c", "d"};

/// Skin whose sensors are moved by three muscles together, and a little each by itself.
struct Skin {
  Eigen::MatrixXd muscles = Eigen::MatrixXd::Zero(3 * kSensors, 3);  // Degrees.
  sensor::SkinMotion motion;

  Skin() {
    Random random(5);
    for (double& entry : muscles.reshaped()) entry = 10 * random.normal();
    motion.sensors = kNames;
    motion.mean_deg = Eigen::VectorXd::LinSpaced(3 * kSensors, -3, 4);
    Eigen::MatrixXd covariance = muscles * muscles.transpose();
    covariance.diagonal().array() += 1;
    motion.factor_deg = covariance.llt().matrixL();
  }

  /// Rotation vectors of one moment, rad.
  [[nodiscard]] Eigen::VectorXd draw(Random& random) const {
    Eigen::VectorXd deg(3 * kSensors);
    for (double& entry : deg) entry = random.normal();
    return kRadPerDeg * (motion.mean_deg + motion.factor_deg * deg);
  }
};

/// A heading's error by its measurement alone (weighted least squares).
struct HeadingError {
  double error_rad, sigma_rad;
};
HeadingError heading_error(const SkinMeasurement& measurement) {
  const Vec3 weighed = measurement.residual_cov_rad2.inverse() * measurement.heading_jacobian;
  const double information = weighed.dot(measurement.heading_jacobian);
  return {weighed.dot(measurement.residual_rad) / information, 1 / std::sqrt(information)};
}

void see(SkinTurns& turns, const Eigen::VectorXd& rotations, std::size_t sensor, const Vec3& up,
         double error) {
  const Vec3 skin = rotations.segment<3>(static_cast<Eigen::Index>(3 * sensor));
  turns.add(sensor, log_rotation(exp_rotation(error * up) * exp_rotation(skin)));
}

TEST(SkinTurns, FindsHeadingsByTheTiltsThatGravityDetermines) {
  const Skin skin;
  SkinTurns turns(skin.motion, kNames);
  Random random(1);
  for (const Vec3& up : {Vec3(0, 1, 0), Vec3(0.3, 0.9, -0.2), Vec3(0.9, 0.1, 0.4)}) {
    const Vec3 vertical = up.normalized();
    double squares = 0, plain = 0;
    constexpr int kMoments = 500;
    for (int moment = 0; moment < kMoments; ++moment) {
      const Eigen::VectorXd rotations = skin.draw(random);
      turns.clear();
      for (std::size_t i = 0; i < kSensors; ++i)
        see(turns, rotations, i, vertical, 4 * kRadPerDeg * static_cast<double>(i));
      turns.solve(vertical);
      for (std::size_t i = 0; i < kSensors; ++i) {
        const HeadingError heading = heading_error(turns[i]);
        const double strayed = heading.error_rad - 4 * kRadPerDeg * static_cast<double>(i);
        squares += strayed * strayed / (heading.sigma_rad * heading.sigma_rad);
        const double turn = rotations.segment<3>(static_cast<Eigen::Index>(3 * i)).dot(vertical);
        plain += turn * turn / (heading.sigma_rad * heading.sigma_rad);
      }
    }
    // It strays as far as it says (a little less: it leaves room for what sensors are off), and a turn by
    // itself would stray much farther.
    EXPECT_NEAR(squares / (kMoments * kSensors), 0.7, 0.3) << up.transpose();
    EXPECT_GT(plain / squares, 10) << up.transpose();
  }
}

TEST(SkinTurns, TellsHowStronglyAFaceMoves) {
  const Skin skin;
  SkinTurns turns(skin.motion, kNames);
  const auto strength = [&](double share, double heading_rad) {
    Random random(4);
    double sum = 0;
    for (int moment = 0; moment < 200; ++moment) {
      const Eigen::VectorXd rotations = share * skin.draw(random);
      turns.clear();
      for (std::size_t i = 0; i < kSensors; ++i) see(turns, rotations, i, Vec3::UnitY(), heading_rad);
      turns.solve(Vec3::UnitY());
      sum += turns[0].strength / 200;
    }
    return sum;
  };
  const double usual = strength(1, 0);
  EXPECT_NEAR(usual, 0.9, 0.2);
  EXPECT_NEAR(strength(0.4, 0) / usual, 0.4, 0.03);
  EXPECT_NEAR(strength(1, 10 * kRadPerDeg) / usual, 1, 0.05) << "headings have no say in it";
  EXPECT_GT(strength(0, 0), 0);
}

TEST(SkinTurns, WhoIsNotSeenIsNotAsked) {
  const Skin skin;
  SkinTurns turns(skin.motion, kNames);
  // The same skin, measured without the sensor that will be missing.
  sensor::SkinMotion fewer;
  fewer.sensors = {"a", "c", "d"};
  const std::vector<Eigen::Index> kept = {0, 1, 2, 6, 7, 8, 9, 10, 11};
  fewer.mean_deg = skin.motion.mean_deg(kept);
  const Eigen::MatrixXd covariance = skin.motion.factor_deg * skin.motion.factor_deg.transpose();
  fewer.factor_deg = Eigen::MatrixXd(covariance(kept, kept)).llt().matrixL();
  SkinTurns without(fewer, fewer.sensors);

  Random random(2);
  const Eigen::VectorXd rotations = skin.draw(random);
  const Vec3 up = Vec3(0.1, 1, 0.2).normalized();
  turns.clear();
  without.clear();
  for (const std::size_t i : {0, 2, 3}) {
    const Vec3 turn = rotations.segment<3>(static_cast<Eigen::Index>(3 * i)) + 0.1 * up;
    turns.add(i, turn);
    without.add(i == 0 ? 0 : i - 1, turn);
  }
  turns.solve(up);
  without.solve(up);
  for (const std::size_t i : {0, 2, 3}) {
    const SkinMeasurement& one = turns[i];
    const SkinMeasurement& other = without[i == 0 ? 0 : i - 1];
    EXPECT_LT((one.residual_rad - other.residual_rad).norm(), 1e-6);
    EXPECT_LT((one.residual_cov_rad2 - other.residual_cov_rad2).norm(), 1e-6);
    EXPECT_NEAR(one.strength, other.strength, 1e-6);
  }
}

TEST(SkinTurns, ASensorWithoutStatisticsIsNotPredicted) {
  const Skin skin;
  const std::vector<std::string> names = {"a", "b", "c", "d", "new"};
  SkinTurns turns(skin.motion, names);
  SkinTurns known(skin.motion, kNames);
  Random random(3);
  const Eigen::VectorXd rotations = skin.draw(random);
  turns.clear();
  known.clear();
  for (std::size_t i = 0; i < kSensors; ++i) {
    see(turns, rotations, i, Vec3::UnitY(), 0);
    see(known, rotations, i, Vec3::UnitY(), 0);
  }
  turns.add(4, Vec3(0, 0.2, 0));
  turns.solve(Vec3::UnitY());
  known.solve(Vec3::UnitY());
  for (std::size_t i = 0; i < kSensors; ++i)
    EXPECT_LT((turns[i].residual_rad - known[i].residual_rad).norm(), 1e-8);
  EXPECT_NEAR(heading_error(turns[4]).error_rad, 0.2, 1e-8);
  EXPECT_GT(heading_error(turns[4]).sigma_rad, 9 * kRadPerDeg);
}

TEST(SkinTurns, ReadsTheSameHoweverItWasAskedBefore) {
  const Skin skin;
  SkinTurns turns(skin.motion, kNames);
  turns.clear();
  turns.add(2, Vec3(0.1, 0.1, 0.1));
  turns.solve(Vec3::UnitX());
  turns.clear();
  for (std::size_t i = 0; i < kSensors; ++i) turns.add(i, Vec3::Zero());
  turns.solve(Vec3::UnitY());
  for (std::size_t i = 0; i < kSensors; ++i) EXPECT_EQ(turns[i].residual_cov_rad2, turns.nominal_cov_rad2(i));
}

}  // namespace
}  // namespace mien::imu::skin_turns_test
