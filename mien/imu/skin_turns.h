#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/sensor/rig.h"

namespace mien::imu {

/// A sensor's rotation as a measurement of its heading error. All of frame H.
struct SkinMeasurement {
  /// Residual: rotation vector less its prediction by all sensors' tilts, rad.
  Vec3 residual_rad = Vec3::Zero();
  /// Change of the rotation vector per radian of heading error: u_i of docs/method/fusion.md. Length about 1.
  Vec3 heading_jacobian = Vec3::UnitY();
  /// Covariance of the prediction while a face moves as strongly as people do on average: C_i, rad^2.
  Mat3 residual_cov_rad2 = Mat3::Identity();
  /// How strongly the face moves now, against that average, 0.15 to 4: the residual's standard deviation and
  /// the wearer-specific skin rotation are proportional to it.
  double strength = 1;
};

/// Predicts each sensor's rotation from all sensors' tilts, to make heading errors observable. Gravity
/// determines two components of every sensor's rotation; the third, about the vertical, contains the heading
/// error. Rotations of skin are correlated over the face, so the tilts together predict each rotation
/// (Gaussian conditioning on the rig's `[skin]` statistics), and the residual is heading error or
/// wearer-specific. Deviations scale with how strongly the face moves, which the tilts show too. Formulas:
/// docs/method/fusion.md, "How skin turns". Thread: one at a time.
class SkinTurns {
 public:
  /// `face_sensors`: names, in the order of the numbers of add(). A sensor that `motion` lacks gets a broad
  /// prior (10 degrees an axis, uncorrelated).
  SkinTurns(const sensor::SkinMotion& motion, std::span<const std::string> face_sensors);

  /// Begins a frame: no sensor is present.
  void clear();
  /// A present sensor's rotation vector from its neutral, at its current heading, frame H, rad; and the
  /// additional standard deviation of its tilt (after gaps), rad.
  void add(std::size_t sensor, const Vec3& rotation_vector, double tilt_sigma_rad = 0);
  /// Computes the measurements of the present sensors, for the vertical `up`, unit, frame H. No allocation.
  void solve(const Vec3& up);
  /// Of a sensor that was present at the last solve().
  [[nodiscard]] const SkinMeasurement& operator[](std::size_t sensor) const { return measurements_[sensor]; }
  /// Its residual_cov_rad2 for a face at neutral, the head upright and all sensors present.
  [[nodiscard]] const Mat3& nominal_cov_rad2(std::size_t sensor) const { return nominal_cov_rad2_[sensor]; }

 private:
  // M: second moment of the rotation vectors about neutral, and every sensor's own error, 3n x 3n.
  Eigen::MatrixXd moment_rad2_;
  std::vector<bool> present_;
  std::vector<SkinMeasurement> measurements_;
  std::vector<Mat3> nominal_cov_rad2_;
  Eigen::VectorXd noise_rad2_;  // This frame's additional variance of each component.
  Eigen::VectorXd turn_rad_;    // Rotation vectors of the present sensors.
  // Of solve(): the factor of M and its additions, the inverse K, and K times the rotation vectors.
  Eigen::MatrixXd factor_, inverse_;
  Eigen::VectorXd weighed_;
};

}  // namespace mien::imu
