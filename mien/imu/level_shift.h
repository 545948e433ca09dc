#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cstddef>

#include "mien/imu/level_change.h"
#include "mien/imu/level_jump.h"

namespace mien::imu {

/// Settings of the detector of level shifts. Chosen on virtual performers of seeds 101 to 110
/// (docs/experiments/hours.md).
struct LevelShiftSettings {
  /// Least shift along one direction, standard deviations of this wearer's usual changes from one window to
  /// the next. Raising: fewer expressions are held, fewer shifts are false. Lowering: the reverse. 0: none is
  /// detected.
  double gate = 2.5;
  /// The same of the changes along all directions together: their sum of squares (chi-squared) against its
  /// expectation, in standard deviations. Raising and lowering: likewise.
  double joint_gate = 2.5;
  /// Least shift, rad (0.6 deg): beyond what drift does within two windows. Raising and lowering: likewise.
  double least_rad = 0.0105;
  /// How long a shifted level is kept at most, s. Raising: expressions can be held for longer, what was no
  /// expression misleads for longer. Lowering: the reverse.
  double most_s = 660;
  /// After that time, how long no shift is accepted, s: drift is measured against the mean again. Raising:
  /// drift is bounded better where levels shift often. Lowering: expressions can be held more often.
  double rest_s = 1200;
  /// By how much a measurement along a shifted direction weighs less, as a factor of its variance less one.
  /// Raising: drift along it is followed later. Lowering: held expressions fade sooner.
  double doubt = 0.3;
  /// Jumps are kept until a shift is detected. Its least jump is `least_rad`.
  LevelJumpSettings jump;
};

/// Detects that the level of a signal of many axes (the skin's rotations) has shifted and stays shifted, as
/// while a performer holds an expression: the means of two windows, 20 s each, one after the other, differ by
/// more than this wearer's usually do, along one direction in both halves of the later one, and along all
/// together. Drift cannot do that in seconds. The offset is the new level; it is followed by its running
/// mean, and dropped once the signal is back; after `most_s` it fades. Until a shift is found a jump of the
/// level (LevelJump) stands for it. A shift of one sensor alone, or of all alike, is no expression but an
/// adhesive's, and is ignored. Thread: one at a time. No allocation after construction. Cost: negligible but
/// once a second.
class LevelShift {
 public:
  /// `sensors`: three axes each.
  LevelShift(const LevelShiftSettings& settings, std::size_t sensors);

  /// Begins anew. `usual_rad2`: how the signal scatters, the prior of its changes.
  void start(const Eigen::MatrixXd& usual_rad2);
  /// Nothing is held any more; what was learnt of the usual changes stays.
  void release();
  /// The signal jumped for another reason (states set, other sensors present): windows begin anew.
  void interrupt();
  /// One frame. `deviation_rad`: the signal less its mean and offset_rad(). `directions`: orthonormal, with
  /// variances; those of `missing_rad2` and above are not looked at.
  void add(double dt_s, const Eigen::VectorXd& deviation_rad,
           const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>& directions, double missing_rad2);

  /// Offset of the present level from the mean, rad; zero while none is held.
  [[nodiscard]] const Eigen::VectorXd& offset_rad() const { return total_rad_; }
  /// Factor of the variance of a measurement along a unit vector: 1 where nothing has shifted.
  [[nodiscard]] double variance_factor(const Eigen::Ref<const Eigen::VectorXd>& direction);
  /// Whether a shifted level is held.
  [[nodiscard]] bool held() const { return shifted_ > 0; }

 private:
  using Index = Eigen::Index;
  using Directions = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;
  void follow(double dt_s, const Eigen::VectorXd& deviation_rad);
  void end_second();
  void detect(const Directions& directions, double missing_rad2);
  [[nodiscard]] double limit_rad(const Directions& directions, Index direction);
  void shift(const Eigen::VectorXd& direction, double before_rad, double after_rad, double limit_rad);
  /// Takes a direction out of the shifted ones.
  void exclude(const Eigen::VectorXd& direction);
  void drop();

  LevelShiftSettings settings_;
  LevelJump jump_;
  Eigen::VectorXd offset_rad_, total_rad_;  // Without and with the jump's.
  Eigen::MatrixXd shifted_directions_;      // Orthonormal; the first `shifted_` columns.
  Index shifted_ = 0;
  double held_s_ = 0, since_shift_s_ = 0, rests_s_ = 0;

  Eigen::MatrixXd seconds_rad_;  // Means of the last seconds about the signal's mean, the newest last.
  Index seconds_ = 0;
  Eigen::VectorXd sum_rad_;  // Of the second in progress.
  double sum_s_ = 0;

  UsualChanges usual_;

  // Members, so that nothing is allocated.
  Eigen::VectorXd change_rad_, before_rad_, first_half_rad_, second_half_rad_, scratch_, direction_;
};

}  // namespace mien::imu
