#pragma once

#include <cstddef>

#include "mien/core/rotation.h"

namespace mien::imu {

/// Z(angle): the rotation about the vertical, +Y, from one fusion's world frame to another's.
[[nodiscard]] Quat heading_turn(double angle_rad);
/// The same angle within (-pi, pi], rad.
[[nodiscard]] double wrap_heading(double angle_rad);

/// Sums of P(Z) = R_h^T Z R_i over frames, for every Z at once: Z is linear in 1, cos and sin of its angle,
/// so three 3 x 3 sums suffice for a search over all headings. No frame is stored. Frames and symbols:
/// docs/reference/frames.md; method: docs/method/calibration.md.
class HeadingSums {
 public:
  /// One frame: R_h and R_i, orientations of ear sensor and face sensor, each in its own fusion's world.
  void add(const Quat& q_world_ear, const Quat& q_world_face);
  HeadingSums& operator+=(const HeadingSums& other);
  [[nodiscard]] std::size_t count() const { return count_; }
  /// The mean of P at a heading, projected onto the nearest rotation.
  [[nodiscard]] Quat mean(double heading_rad) const;
  /// Root mean square angle of P from its mean at a heading, rad.
  [[nodiscard]] double spread(double heading_rad) const;

  struct Best {
    double heading_rad = 0;  ///< (-pi, pi]: where the spread of P is least.
    /// Standard deviation, from the remaining spread and how far the head tilted; pi where it did not tilt.
    double sigma_rad = 0;
  };
  /// The heading of least spread. Fewer than two frames: 0 with a sigma of pi.
  [[nodiscard]] Best find() const;

 private:
  [[nodiscard]] double squared_sum(double heading_rad) const;
  Mat3 constant_ = Mat3::Zero();
  Mat3 cosine_ = Mat3::Zero();
  Mat3 sine_ = Mat3::Zero();
  Vec3 up_sum_ = Vec3::Zero();  // Sum of the vertical in the ear sensor's axes.
  std::size_t count_ = 0;
};

}  // namespace mien::imu
