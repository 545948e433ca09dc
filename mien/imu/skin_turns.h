#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/sensor/rig.h"

namespace mien::imu {

/// What a sensor's rotation says of its heading, from how skin turns. All of frame H.
struct SkinReading {
  /// Its rotation vector beyond what all sensors' tilts foretell of it, rad.
  Vec3 beyond_rad = Vec3::Zero();
  /// What an error of the heading adds to a rotation vector, for each radian: about the vertical, as seen
  /// from the rotation that there is.
  Vec3 about = Vec3::UnitY();
  /// How far skin strays from what is foretold while a face moves as people's do on the whole, rad^2, ...
  Mat3 strays_rad2 = Mat3::Identity();
  /// ... and how strongly it moves now: skin strays in that proportion, both as people differ, and from one
  /// moment to the next.
  double strength = 1;
};

/// Tells headings by how skin turns. Gravity holds two of the three components of every sensor's rotation;
/// the third, about the vertical, is as wrong as the sensor's heading. But skin does not turn as it likes:
/// what gravity holds, of all sensors together, foretells each one's rotation, and what is seen beyond is
/// heading's error or the skin's own way. A face at rest has hardly any way of its own: how strongly it moves
/// is told by all tilts, too. Method and what it is worth: docs/method/fusion.md.
class SkinTurns {
 public:
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
  [[nodiscard]] const SkinReading& operator[](std::size_t sensor) const { return readings_[sensor]; }
  /// strays_rad2 of its readings while the face rests, the head is upright and all sensors are there.
  [[nodiscard]] const Mat3& usual_strays_rad2(std::size_t sensor) const { return usual_strays_rad2_[sensor]; }

 private:
  Eigen::MatrixXd
      moment_rad2_;  // Mean square of rotation vectors and of what every sensor is off, 3 n x 3 n.
  std::vector<bool> seen_;
  std::vector<SkinReading> readings_;
  std::vector<Mat3> usual_strays_rad2_;
  Eigen::VectorXd noise_rad2_;  // Of this frame's components besides.
  Eigen::VectorXd turn_rad_;    // What was seen.
  // Of solve(): the factor of all of the mean square, its inverse, and the inverse times what was seen.
  Eigen::MatrixXd factor_, inverse_;
  Eigen::VectorXd weighed_;
};

}  // namespace mien::imu
