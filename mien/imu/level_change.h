#pragma once

#include <Eigen/Core>

namespace mien::imu {

/// How the level of a signal usually changes from one window to the next: second moment over the last 20
/// minutes, about zero. Unit: rad^2, three axes a sensor. Thread: one at a time. No allocation after
/// construction.
class UsualChanges {
 public:
  explicit UsualChanges(Eigen::Index size)
      : moment_rad2_(Eigen::MatrixXd::Zero(size, size)), product_rad2_(Eigen::VectorXd::Zero(size)) {}

  /// Begins anew. `usual_rad2`: how the signal scatters; a quarter of it counts for a minute.
  void start(const Eigen::MatrixXd& usual_rad2);
  /// One second's change, rad.
  void add(const Eigen::VectorXd& change_rad);
  /// Standard deviation along a unit vector, rad, at least 1e-6.
  [[nodiscard]] double along_rad(const Eigen::Ref<const Eigen::VectorXd>& direction);

 private:
  Eigen::MatrixXd moment_rad2_;
  double seconds_ = 0;
  Eigen::VectorXd product_rad2_;  // A member, so that nothing is allocated.
};

/// Changes along all directions together: sum of squares against its expectation (chi-squared).
class JointChange {
 public:
  /// A change, in standard deviations; counts for five at most.
  void add(double deviations);
  /// Beyond the expectation by more than `gate` standard deviations.
  [[nodiscard]] bool beyond(double gate) const;

 private:
  double squares_ = 0, count_ = 0;
};

/// Whether a change of the skin's rotations is an adhesive's rather than an expression's: of one sensor
/// alone, or common to all. `change_rad`: three axes a sensor, zero where it is absent.
[[nodiscard]] bool is_displacement(const Eigen::VectorXd& change_rad);

}  // namespace mien::imu
