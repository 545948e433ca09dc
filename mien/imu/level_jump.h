#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "mien/imu/level_change.h"

namespace mien::imu {

/// Settings of the detector of level jumps. Chosen on virtual performers of seeds 101 to 110
/// (docs/experiments/hours.md).
struct LevelJumpSettings {
  /// Least jump along one direction, standard deviations of this wearer's usual changes within seconds.
  /// Raising: fewer expressions are kept from the first second on, fewer jumps are false. Lowering: the
  /// reverse. 0: none is detected.
  double gate = 3;
  /// The same along all directions together. Raising and lowering: likewise.
  double joint_gate = 4;
  /// How long a jump is kept that no shift of the level confirms, s. Raising: shifts may be confirmed later,
  /// false jumps mislead for longer. Lowering: the reverse.
  double most_s = 25;
};

/// Detects within two seconds that the level of the skin's rotations has jumped, before LevelShift, which
/// needs 11 to 20 s, can know whether it stays. Until then the jump is an offset along its direction, so
/// that no drift is corrected by it: the mean of the last two seconds differs from that of the ten before by
/// more than this wearer's usually do. It ends as the signal comes back, as LevelShift finds a shift, or
/// after `most_s`. Thread: one at a time. No allocation after construction. Cost: negligible but once a
/// second.
class LevelJump {
 public:
  /// Seconds that look() needs.
  static constexpr Eigen::Index kLast = 2, kBefore = 10;

  /// `least_rad`: least jump, rad. `size`: three axes a sensor.
  LevelJump(const LevelJumpSettings& settings, double least_rad, Eigen::Index size);

  /// Begins anew. `usual_rad2`: how the signal scatters, the prior of its changes.
  void start(const Eigen::MatrixXd& usual_rad2);
  /// No jump is held any more; what was learnt of the usual changes stays.
  void drop();
  /// One frame. `deviation_rad`: the signal less its level and offset_rad().
  void follow(double dt_s, const Eigen::VectorXd& deviation_rad);
  /// Once a second. `seconds_rad`: means of the last seconds about the signal's mean, the newest last.
  /// `level_rad`: LevelShift's offset. `directions`: orthonormal, with variances; those of `missing_rad2` and
  /// above are not looked at. `permitted`: whether a new jump may be held.
  void look(const Eigen::MatrixXd& seconds_rad, const Eigen::VectorXd& level_rad,
            const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>& directions, double missing_rad2,
            bool permitted);

  /// Offset of the present level from LevelShift's, rad; zero while none is held.
  [[nodiscard]] const Eigen::VectorXd& offset_rad() const { return offset_rad_; }
  [[nodiscard]] bool held() const { return held_; }

 private:
  LevelJumpSettings settings_;
  double least_rad_;
  UsualChanges usual_;
  Eigen::VectorXd offset_rad_, direction_;
  bool held_ = false;
  double held_s_ = 0;
  Eigen::VectorXd change_rad_, jump_rad_;  // Members, so that nothing is allocated.
};

}  // namespace mien::imu
