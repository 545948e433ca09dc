#include "mien/imu/level_shift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mien/core/random.h"
#include "mien/core/units.h"

namespace mien::imu::level_shift_test {
namespace {

constexpr std::size_t kSensors = 4;
constexpr Eigen::Index kAxes = 3 * kSensors, kMuscles = 3;
constexpr double kFrame_s = 1 / 30.0;

/// Skin that three muscles move, each by another amount about every second; rad.
struct Skin {
  Random random;
  Eigen::MatrixXd muscles_rad = Eigen::MatrixXd::Zero(kAxes, kMuscles);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> directions;
  Eigen::MatrixXd scatter_rad2;
  Eigen::VectorXd activity = Eigen::VectorXd::Zero(kMuscles);
  Eigen::VectorXd held_rad = Eigen::VectorXd::Zero(kAxes);
  LevelShift level;
  double held_s = 0;  ///< How long a level was held.
  double t_s = 0, next_s = 0;

  explicit Skin(std::uint64_t seed, const LevelShiftSettings& settings = {})
      : random(seed), level(settings, kSensors) {
    for (double& entry : muscles_rad.reshaped()) entry = 0.7 * kRadPerDeg * random.normal();
    scatter_rad2 = muscles_rad * muscles_rad.transpose();
    scatter_rad2.diagonal().array() += std::pow(0.5 * kRadPerDeg, 2);
    directions.compute(scatter_rad2);
    level.start(scatter_rad2);
  }

  void add() {
    t_s += kFrame_s;
    if (t_s >= next_s) {
      for (double& one : activity) one = random.normal();
      next_s = t_s + 0.3 + random.exponential(0.7);
    }
    Eigen::VectorXd deviation_rad = muscles_rad * activity + held_rad - level.offset_rad();
    for (double& axis : deviation_rad) axis += random.normal(0, 0.5 * kRadPerDeg);
    level.add(kFrame_s, deviation_rad, directions, std::numeric_limits<double>::infinity());
    if (level.held()) held_s += kFrame_s;
  }
  void wear(double seconds) {
    for (int i = 0; i < std::lround(seconds / kFrame_s); ++i) add();
  }
  /// How much of the held expression the offset is, along it.
  [[nodiscard]] double found(const Eigen::VectorXd& expression_rad) const {
    return level.offset_rad().dot(expression_rad) / expression_rad.squaredNorm();
  }
};

/// Brows that two sensors feel.
Eigen::VectorXd brows() {
  Eigen::VectorXd rad = Eigen::VectorXd::Zero(kAxes);
  rad.head<6>() << -3, 0.5, 1, -2.5, -0.5, -1;
  return kRadPerDeg * rad;
}

TEST(LevelShift, FindsAHeldExpressionAndItsEnd) {
  Skin skin(1);
  skin.wear(300);
  EXPECT_FALSE(skin.level.held());
  skin.held_rad = brows();
  skin.wear(30);
  EXPECT_TRUE(skin.level.held());
  EXPECT_NEAR(skin.found(brows()), 0.9, 0.25);
  EXPECT_GT(skin.level.variance_factor(brows().normalized()), 1.1);
  skin.wear(300);
  EXPECT_NEAR(skin.found(brows()), 0.9, 0.2);
  skin.held_rad.setZero();
  skin.wear(30);
  EXPECT_FALSE(skin.level.held());
  EXPECT_EQ(skin.level.offset_rad().norm(), 0);
  EXPECT_EQ(skin.level.variance_factor(brows().normalized()), 1);
}

TEST(LevelShift, AJumpStandsForAShiftThatIsNotFoundYet) {
  for (const std::uint64_t seed : {4, 5, 6}) {
    LevelShiftSettings slow;
    slow.jump.gate = 0;
    Skin skin(seed), without(seed, slow);
    for (Skin* one : {&skin, &without}) {
      one->wear(300);
      one->held_rad = brows();
      one->wear(5);
      EXPECT_FALSE(one->level.held()) << "no shift within five seconds";
    }
    EXPECT_GT(skin.found(brows()), 0.45) << seed;
    EXPECT_EQ(without.level.offset_rad().norm(), 0);
    // What was no more than a gesture leaves nothing.
    skin.held_rad.setZero();
    skin.wear(4);
    EXPECT_LT(skin.found(brows()), 0.1) << seed;
  }
}

TEST(LevelShift, AJumpThatNoShiftConfirmsEnds) {
  LevelShiftSettings settings;
  settings.gate = 1e6;
  Skin skin(7, settings);
  skin.wear(300);
  skin.held_rad = brows();
  skin.wear(settings.jump.most_s);
  EXPECT_NEAR(skin.found(brows()), 0.9, 0.3);
  skin.wear(5);
  EXPECT_EQ(skin.level.offset_rad().norm(), 0);
}

TEST(LevelShift, UsualMotionShiftsNothing) {
  double held_s = 0;
  for (std::uint64_t seed = 11; seed < 14; ++seed) {
    Skin skin(seed);
    skin.wear(1200);
    held_s += skin.held_s;
  }
  EXPECT_LT(held_s, 0.02 * 3600);
}

TEST(LevelShift, SlowDriftIsNone) {
  Skin skin(2);
  skin.wear(120);
  // Eight degrees in a quarter of an hour.
  for (int i = 0; i < 900; ++i) {
    skin.held_rad += brows() * (2.0 / 900);
    skin.wear(1);
  }
  EXPECT_LT(skin.held_s, 0.05 * 900);
}

TEST(LevelShift, AnAdhesiveThatJumpsIsNoExpression) {
  Skin one(3), all(3);
  one.wear(300);
  all.wear(300);
  one.held_rad.segment<3>(3) = Eigen::Vector3d(4, -5, 5) * kRadPerDeg;
  for (Eigen::Index i = 0; i < kAxes; i += 3)
    all.held_rad.segment<3>(i) = Eigen::Vector3d(2, 4, -3) * kRadPerDeg;
  one.wear(200);
  all.wear(200);
  EXPECT_EQ(one.held_s, 0);
  EXPECT_EQ(all.held_s, 0);
}

TEST(LevelShift, HoldsNoLongerThanItsMost) {
  LevelShiftSettings settings;
  settings.most_s = 100;
  settings.rest_s = 300;
  Skin skin(4, settings);
  skin.wear(200);
  skin.held_rad = brows();
  skin.wear(60);
  ASSERT_TRUE(skin.level.held());
  skin.wear(100);
  EXPECT_FALSE(skin.level.held());
  skin.wear(200);
  EXPECT_LT(skin.level.offset_rad().norm(), 0.1 * brows().norm()) << "faded";
  // A shift while it rests is not accepted; afterwards one is.
  skin.held_rad.setZero();
  skin.wear(60);
  EXPECT_FALSE(skin.level.held());
  skin.wear(100);
  skin.held_rad = brows();
  skin.wear(40);
  EXPECT_TRUE(skin.level.held());
}

TEST(LevelShift, LevelsThatComeAndGoAreNotHeld) {
  Skin skin(5);
  skin.wear(300);
  skin.held_rad = brows();
  skin.wear(60);
  ASSERT_TRUE(skin.level.held());
  // Another expression, two minutes each.
  Eigen::VectorXd other = Eigen::VectorXd::Zero(kAxes);
  other.tail<6>() << -1, 4, 2, -2, -4, 1;
  skin.held_rad = kRadPerDeg * other;
  skin.wear(60);
  EXPECT_FALSE(skin.level.held());
  skin.held_s = 0;
  skin.held_rad = brows();
  skin.wear(120);
  EXPECT_EQ(skin.held_s, 0) << "drift is measured against the mean";
}

TEST(LevelShift, AnInterruptionBeginsTheWindowsAnew) {
  Skin skin(6);
  skin.wear(300);
  skin.held_rad = brows();
  skin.level.interrupt();
  skin.wear(120);
  EXPECT_FALSE(skin.level.held()) << "what was before is not known";
}

TEST(LevelShift, NoneIsDetectedWithoutAGate) {
  LevelShiftSettings settings;
  settings.gate = 0;
  Skin skin(1, settings);
  skin.wear(300);
  skin.held_rad = brows();
  skin.wear(60);
  EXPECT_FALSE(skin.level.held());
}

}  // namespace
}  // namespace mien::imu::level_shift_test
