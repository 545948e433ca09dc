#include "mien/imu/level_jump.h"

#include <algorithm>
#include <cmath>

namespace mien::imu {
namespace {

/// A jump is along those directions that change by more than so many standard deviations.
constexpr double kDeviationsOfJump = 1.5;
/// A jump leads away from the level by at least this share of it; another one leads back.
constexpr double kAwayShare = 0.5;
/// The signal is back where less than this share of the jump is left.
constexpr double kJumpBackShare = 0.4;
/// The offset is the running mean since the jump, as if that had been this long before, s.
constexpr double kJumpMean_s = 3;

}  // namespace

LevelJump::LevelJump(const LevelJumpSettings& settings, double least_rad, Eigen::Index size)
    : settings_(settings), least_rad_(least_rad), usual_(size) {
  offset_rad_ = direction_ = change_rad_ = jump_rad_ = Eigen::VectorXd::Zero(size);
}

void LevelJump::start(const Eigen::MatrixXd& usual_rad2) {
  usual_.start(usual_rad2);
  drop();
}

void LevelJump::drop() {
  held_ = false;
  offset_rad_.setZero();
}

void LevelJump::follow(double dt_s, const Eigen::VectorXd& deviation_rad) {
  if (!held_) return;
  held_s_ += dt_s;
  offset_rad_ += dt_s / (kJumpMean_s + held_s_) * direction_.dot(deviation_rad) * direction_;
  if (held_s_ > settings_.most_s) drop();
}

void LevelJump::look(const Eigen::MatrixXd& seconds_rad, const Eigen::VectorXd& level_rad,
                     const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>& directions, double missing_rad2,
                     bool permitted) {
  if (settings_.gate <= 0) return;
  const auto newest = seconds_rad.rightCols<1>();
  if (held_) {
    const double left_rad = direction_.dot(newest) - direction_.dot(level_rad);
    const double jump_rad = direction_.dot(offset_rad_);
    if (left_rad * jump_rad < kJumpBackShare * jump_rad * jump_rad) drop();
    return;
  }
  change_rad_ = seconds_rad.rightCols<kLast>().rowwise().mean() -
                seconds_rad.middleCols(seconds_rad.cols() - kLast - kBefore, kBefore).rowwise().mean();
  JointChange joint;
  bool any = false;
  double most = 1;
  jump_rad_.setZero();
  for (Eigen::Index k = 0; k < directions.eigenvectors().cols(); ++k) {
    if (directions.eigenvalues()[k] >= missing_rad2) continue;
    const auto along = directions.eigenvectors().col(k);
    const double change_rad = along.dot(change_rad_);
    const double deviations = change_rad / usual_.along_rad(along);
    joint.add(deviations);
    most = std::max(most, std::abs(deviations) / settings_.gate);
    any = any || (std::abs(deviations) > settings_.gate && std::abs(change_rad) > least_rad_);
    if (std::abs(deviations) > kDeviationsOfJump) jump_rad_ += change_rad * along;
  }
  const bool jumped = any && permitted && joint.beyond(settings_.joint_gate);
  const double jump_rad = jump_rad_.norm();
  if (jumped && jump_rad > least_rad_ && !is_displacement(change_rad_)) {
    direction_ = jump_rad_ / jump_rad;
    const double off_rad = direction_.dot(newest) - direction_.dot(level_rad);
    if (off_rad > kAwayShare * jump_rad) {
      offset_rad_ = off_rad * direction_;
      held_ = true;
      held_s_ = 0;
    }
  }
  // A jump counts among the usual changes for no more than the gate.
  if (jumped) change_rad_ /= most;
  usual_.add(change_rad_);
}

}  // namespace mien::imu
