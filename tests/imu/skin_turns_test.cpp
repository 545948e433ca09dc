#include "mien/imu/skin_turns.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numbers>
#include <string>
#include <vector>

#include "mien/core/random.h"

namespace mien::imu {
namespace {

constexpr double kDeg = std::numbers::pi / 180;
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
    return kDeg * (motion.mean_deg + motion.factor_deg * deg);
  }
};

void see(SkinTurns& turns, const Eigen::VectorXd& rotations, std::size_t sensor, const Vec3& up,
         double error) {
  turns.see(sensor, rotations.segment<3>(static_cast<Eigen::Index>(3 * sensor)) + error * up);
}

TEST(SkinTurns, TellsHeadingsByWhatGravityHolds) {
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
        see(turns, rotations, i, vertical, 25 * kDeg * static_cast<double>(i));
      turns.solve(vertical);
      for (std::size_t i = 0; i < kSensors; ++i) {
        const double strayed = turns[i].turn_rad - 25 * kDeg * static_cast<double>(i);
        squares += strayed * strayed / (turns[i].sigma_rad * turns[i].sigma_rad);
        const double turn = rotations.segment<3>(static_cast<Eigen::Index>(3 * i)).dot(vertical);
        plain += turn * turn / (turns[i].sigma_rad * turns[i].sigma_rad);
      }
    }
    // It strays as far as it says (a little less: it leaves room for what sensors are off), and a turn by
    // itself would stray much farther.
    EXPECT_NEAR(squares / (kMoments * kSensors), 0.7, 0.3) << up.transpose();
    EXPECT_GT(plain / squares, 10) << up.transpose();
  }
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
    see(turns, rotations, i, up, 0.1);
    without.see(i == 0 ? 0 : i - 1, rotations.segment<3>(static_cast<Eigen::Index>(3 * i)) + 0.1 * up);
  }
  turns.solve(up);
  without.solve(up);
  for (const std::size_t i : {0, 2, 3}) {
    EXPECT_NEAR(turns[i].turn_rad, without[i == 0 ? 0 : i - 1].turn_rad, 1e-8);
    EXPECT_NEAR(turns[i].sigma_rad, without[i == 0 ? 0 : i - 1].sigma_rad, 1e-8);
  }
}

TEST(SkinTurns, OfASensorThatNobodyMeasuredNothingIsForetold) {
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
  turns.see(4, Vec3(0.1, 0.2, -0.1));
  turns.solve(Vec3::UnitY());
  known.solve(Vec3::UnitY());
  for (std::size_t i = 0; i < kSensors; ++i) EXPECT_NEAR(turns[i].turn_rad, known[i].turn_rad, 1e-8);
  EXPECT_NEAR(turns[4].turn_rad, 0.2, 1e-8);
  EXPECT_GT(turns[4].sigma_rad, 9 * kDeg);
}

TEST(SkinTurns, ReadsTheSameHoweverItWasAskedBefore) {
  const Skin skin;
  SkinTurns turns(skin.motion, kNames);
  const double at_first = turns[1].sigma_rad;
  EXPECT_GT(at_first, 0);
  turns.clear();
  turns.see(2, Vec3(0.1, 0.1, 0.1));
  turns.solve(Vec3::UnitX());
  turns.clear();
  for (std::size_t i = 0; i < kSensors; ++i) turns.see(i, Vec3::Zero());
  turns.solve(Vec3::UnitY());
  EXPECT_EQ(turns[1].sigma_rad, at_first);
}

}  // namespace
}  // namespace mien::imu
