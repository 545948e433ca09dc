#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/sensor/rig.h"

namespace mien::imu {

/// Tells headings by how skin turns. Gravity holds two of the three components of every sensor's rotation;
/// the third, about the vertical, is as wrong as the sensor's heading. But skin does not turn as it likes:
/// what gravity holds, of all sensors together, foretells their turns about the vertical, and what is seen
/// beyond is heading's error. Least squares of the rotations, weighed by the inverse of their covariance,
/// with one unknown a heading (Gauss and Markov). Method and what it is worth: docs/fusion.md.
class SkinTurns {
 public:
  /// Of one sensor at the last solve().
  struct Reading {
    double turn_rad = 0;   ///< Its turn about the vertical beyond what was foretold.
    double sigma_rad = 0;  ///< One sigma of how far skin itself strays from what was foretold.
  };

  /// `face_sensors`: names, in the order of see()'s numbers. Of one that `motion` does not tell of, nothing
  /// is foretold.
  SkinTurns(const sensor::SkinMotion& motion, std::span<const std::string> face_sensors);

  /// A new frame, in which no sensor was seen.
  void clear();
  /// A face sensor's rotation vector against its neutral, frame H, rad, by the heading it has now; and how
  /// unsure what gravity holds of it is, rad, one sigma, beyond what any sensor's is.
  void see(std::size_t sensor, const Vec3& rotation_vector, double tilt_sigma_rad = 0);
  /// Works out the readings of the sensors that were seen, for the vertical `up`, frame H. No allocation.
  void solve(const Vec3& up);
  [[nodiscard]] const Reading& operator[](std::size_t sensor) const { return readings_[sensor]; }
  /// The sigma of its readings while the head is upright and all sensors are there.
  [[nodiscard]] double usual_sigma_rad(std::size_t sensor) const { return usual_sigma_rad_[sensor]; }

 private:
  Eigen::MatrixXd covariance_rad2_;  // Of rotation vectors and of what every sensor is off, 3 n x 3 n.
  Eigen::VectorXd mean_rad_;
  std::vector<bool> seen_;
  std::vector<Reading> readings_;
  std::vector<double> usual_sigma_rad_;
  Eigen::VectorXd noise_rad2_;  // Of this frame's components besides.
  Eigen::VectorXd beyond_rad_;  // What was seen, less the mean.
  // Of solve(): the factor of all of the covariance, the design with a column a heading, and its normal
  // equations.
  Eigen::MatrixXd factor_, design_, normal_;
  Eigen::VectorXd right_, unit_;
};

}  // namespace mien::imu
