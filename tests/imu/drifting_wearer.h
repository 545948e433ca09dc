#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/random.h"
#include "mien/core/rotation.h"
#include "mien/core/units.h"
#include "mien/imu/drift_filter.h"
#include "mien/sensor/rig.h"

namespace mien::imu::test {

inline constexpr std::size_t kSensors = 4;
inline constexpr Eigen::Index kAxes = 3 * kSensors, kMuscles = 3;
inline constexpr double kFrame_s = 1 / 30.0;
inline const std::vector<std::string> kNames = {"a", "b", "c", "d"};

/// Skin whose sensors are moved by three muscles together; degrees at an activity of one.
struct Skin {
  Eigen::MatrixXd muscles_deg = Eigen::MatrixXd::Zero(kAxes, kMuscles);
  sensor::SkinMotion people;

  Skin() {
    Random random(5);
    for (double& entry : muscles_deg.reshaped()) entry = 3 * random.normal();
    people.sensors = kNames;
    people.mean_deg = Eigen::VectorXd::LinSpaced(kAxes, -3, 4);
    Eigen::MatrixXd covariance = muscles_deg * muscles_deg.transpose();
    covariance.diagonal().array() += 1;
    people.factor_deg = covariance.llt().matrixL();
  }
};

/// A wearer whose activities change about every second, whose head nods and turns, and whose sensors drift.
struct Wearer {
  Random random;
  Eigen::MatrixXd muscles_rad;
  Eigen::VectorXd mean_rad;
  Eigen::Vector3d activity = Eigen::Vector3d::Zero(), goal = Eigen::Vector3d::Zero();
  bool holds = false;  ///< The goal stays.
  double t_s = 0, next_goal_s = 0;
  Eigen::VectorXd skin_rad = Eigen::VectorXd::Zero(kAxes);
  // Truth.
  std::array<double, kSensors> heading_rad{};
  std::array<Vec3, kSensors> creep_rad;
  Vec3 ear_creep_rad = Vec3::Zero();
  std::array<bool, kSensors> present{};

  explicit Wearer(std::uint64_t seed) : random(seed) {
    const Skin skin;
    // This one's muscles pull in directions somewhat other than people's.
    muscles_rad = kRadPerDeg * skin.muscles_deg;
    for (double& entry : muscles_rad.reshaped()) entry += 0.6 * kRadPerDeg * random.normal();
    mean_rad = kRadPerDeg * skin.people.mean_deg;
    creep_rad.fill(Vec3::Zero());
    present.fill(true);
  }

  [[nodiscard]] Vec3 up() const {
    const Quat head = exp_rotation(Vec3(0.25 * std::sin(0.9 * t_s), 0, 0)) *
                      exp_rotation(Vec3(0, 0, 0.15 * std::sin(0.53 * t_s)));
    return head.conjugate() * Vec3::UnitY();
  }

  void move() {
    t_s += kFrame_s;
    if (!holds && t_s >= next_goal_s) {
      goal = random.normal_vector(1);
      next_goal_s = t_s + 0.3 + random.exponential(0.7);
    }
    activity += kFrame_s / 0.15 * (goal - activity);
    skin_rad = mean_rad + muscles_rad * activity;
    for (double& axis : skin_rad) axis += random.normal(0, 0.2 * kRadPerDeg);
  }

  /// Estimate less truth, rad.
  [[nodiscard]] double heading_error(const DriftFilter& filter, std::size_t i) const {
    return std::remainder(filter.heading_rad(i) - heading_rad[i], 2 * std::numbers::pi);
  }
  /// E_i by the filter's present states, of skin that turns by `skin`.
  [[nodiscard]] Vec3 estimated_turn(const DriftFilter& filter, std::size_t i, const Vec3& skin) const {
    return log_rotation(exp_rotation(filter.ear_creep_rad()) * exp_rotation(-ear_creep_rad) *
                        exp_rotation(heading_error(filter, i) * up()) * exp_rotation(skin) *
                        exp_rotation(creep_rad[i]) * exp_rotation(-filter.creep_rad(i)));
  }
  /// What headings and creep leave in E_i, rad.
  [[nodiscard]] Vec3 turn_error(const DriftFilter& filter, std::size_t i) const {
    return estimated_turn(filter, i, Vec3::Zero());
  }
  [[nodiscard]] Vec3 skin_of(std::size_t i) const {
    return skin_rad.segment<3>(static_cast<Eigen::Index>(3 * i));
  }

  /// One frame.
  void add_to(DriftFilter& filter, double tilt_rad2 = 0) {
    move();
    filter.predict(kFrame_s);
    std::array<std::optional<Vec3>, kSensors> turns;
    for (std::size_t i = 0; i < kSensors; ++i)
      if (present[i]) turns[i] = estimated_turn(filter, i, skin_of(i));
    std::array<double, kSensors> tilts{};
    tilts.fill(tilt_rad2);
    filter.add_skin(kFrame_s, turns, tilts, up());
  }
  /// Frames, each after `drift` has changed the truth.
  template <typename Drift>
  void wear(DriftFilter& filter, double seconds, Drift drift) {
    for (int i = 0; i < std::lround(seconds / kFrame_s); ++i) {
      drift();
      add_to(filter);
    }
  }
  void wear(DriftFilter& filter, double seconds) {
    wear(filter, seconds, [] {});
  }
};

/// A filter after a calibration.
inline DriftFilter calibrated(const std::optional<sensor::SkinMotion>& people,
                              const DriftSettings& settings = {}) {
  DriftFilter filter(settings, people, kNames);
  for (std::size_t i = 0; i < kSensors; ++i) filter.move_to(i, 0, 0.5 * kRadPerDeg);
  return filter;
}
inline DriftFilter calibrated() {
  return calibrated(Skin().people);
}

}  // namespace mien::imu::test
