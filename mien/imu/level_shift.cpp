#include "mien/imu/level_shift.h"

#include <algorithm>
#include <cmath>

namespace mien::imu {
namespace {

/// Windows, in seconds.
constexpr Eigen::Index kWindow = 20, kHalf = kWindow / 2;
/// Least shift against the wearer's standard deviation along the direction.
constexpr double kLeastOfDeviation = 0.7;
/// Each half of the later window has at least this share of the least shift; once one direction has shifted,
/// the others need this share of theirs.
constexpr double kShareOfHalf = 0.7, kShareOfOthers = 0.5;
/// A direction is back where less than this share of its change, or of its limit, is left; all of them where
/// less than this share of the level is left.
constexpr double kBackShare = 0.5, kAllBackShare = 0.6;
/// A later change of at least this share of the offset is to another level.
constexpr double kAnotherShare = 0.6;
/// An offset that is kept no more fades with this time constant, s.
constexpr double kFadeS = 60;
/// What is left of a column after a direction was taken out of it, to be kept.
constexpr double kLeastLeft = 0.3;

}  // namespace

LevelShift::LevelShift(const LevelShiftSettings& settings, std::size_t sensors)
    : settings_(settings),
      jump_(settings.jump, settings.least_rad, static_cast<Index>(3 * sensors)),
      usual_(static_cast<Index>(3 * sensors)) {
  const auto size = static_cast<Index>(3 * sensors);
  offset_rad_ = total_rad_ = sum_rad_ = change_rad_ = before_rad_ = first_half_rad_ = second_half_rad_ =
      scratch_ = direction_ = Eigen::VectorXd::Zero(size);
  shifted_directions_ = Eigen::MatrixXd::Zero(size, size);
  seconds_rad_ = Eigen::MatrixXd::Zero(size, 2 * kWindow);
}

void LevelShift::start(const Eigen::MatrixXd& usual_rad2) {
  usual_.start(usual_rad2);
  jump_.start(usual_rad2);
  rests_s_ = 0;
  release();
}

void LevelShift::release() {
  drop();
  interrupt();
}

void LevelShift::interrupt() {
  jump_.drop();
  total_rad_ = offset_rad_;
  seconds_ = 0;
  sum_rad_.setZero();
  sum_s_ = 0;
}

void LevelShift::drop() {
  shifted_ = 0;
  held_s_ = 0;
  offset_rad_.setZero();
}

double LevelShift::variance_factor(const Eigen::Ref<const Eigen::VectorXd>& direction) {
  if (shifted_ == 0) return 1;
  scratch_.head(shifted_).noalias() = shifted_directions_.leftCols(shifted_).transpose() * direction;
  return 1 + settings_.doubt * scratch_.head(shifted_).squaredNorm();
}

void LevelShift::follow(double dt_s, const Eigen::VectorXd& deviation_rad) {
  if (rests_s_ > 0) {
    rests_s_ -= dt_s;
    offset_rad_ *= 1 - std::min(1.0, dt_s / kFadeS);
  }
  if (shifted_ == 0) return;
  held_s_ += dt_s;
  since_shift_s_ += dt_s;
  scratch_.head(shifted_).noalias() = shifted_directions_.leftCols(shifted_).transpose() * deviation_rad;
  offset_rad_.noalias() += (dt_s / (static_cast<double>(kWindow) + since_shift_s_)) *
                           shifted_directions_.leftCols(shifted_) * scratch_.head(shifted_);
  if (held_s_ <= settings_.most_s) return;
  shifted_ = 0;
  held_s_ = 0;
  rests_s_ = settings_.rest_s;
}

void LevelShift::end_second() {
  for (Index second = 0; second + 1 < seconds_rad_.cols(); ++second)
    seconds_rad_.col(second) = seconds_rad_.col(second + 1);
  seconds_rad_.rightCols<1>() = sum_rad_ / sum_s_;
  sum_rad_.setZero();
  sum_s_ = 0;
  ++seconds_;
}

double LevelShift::limit_rad(const Directions& directions, Index direction) {
  const double scatter_rad = std::sqrt(std::max(0.0, directions.eigenvalues()[direction]));
  return std::max({settings_.least_rad, kLeastOfDeviation * scatter_rad,
                   settings_.gate * usual_.along_rad(directions.eigenvectors().col(direction))});
}

void LevelShift::exclude(const Eigen::VectorXd& direction) {
  Index kept = 0;
  for (Index column = 0; column < shifted_; ++column) {
    scratch_ = shifted_directions_.col(column);
    scratch_ -= direction.dot(scratch_) * direction;
    for (Index earlier = 0; earlier < kept; ++earlier)
      scratch_ -= shifted_directions_.col(earlier).dot(scratch_) * shifted_directions_.col(earlier);
    const double left = scratch_.norm();
    if (left > kLeastLeft) shifted_directions_.col(kept++) = scratch_ / left;
  }
  shifted_ = kept;
}

void LevelShift::shift(const Eigen::VectorXd& direction, double before_rad, double after_rad,
                       double limit_rad) {
  exclude(direction);
  const double change_rad = after_rad - before_rad;
  const bool back = std::abs(after_rad) < std::max(kBackShare * std::abs(change_rad), limit_rad);
  offset_rad_ += ((back ? 0 : after_rad) - direction.dot(offset_rad_)) * direction;
  // Not detected twice.
  for (Index second = 0; second < kWindow; ++second) seconds_rad_.col(second) += change_rad * direction;
  if (back) return;
  shifted_directions_.col(shifted_++) = direction;
  since_shift_s_ = 0;
}

void LevelShift::detect(const Directions& directions, double missing_rad2) {
  const auto& axes = directions.eigenvectors();
  scratch_ = seconds_rad_.leftCols(kWindow).rowwise().mean();
  before_rad_.noalias() = axes.transpose() * scratch_;
  change_rad_ = seconds_rad_.rightCols(kWindow).rowwise().mean() - scratch_;
  scratch_ = seconds_rad_.middleCols(kWindow, kHalf).rowwise().mean();
  first_half_rad_.noalias() = axes.transpose() * scratch_;
  scratch_ = seconds_rad_.rightCols(kHalf).rowwise().mean();
  second_half_rad_.noalias() = axes.transpose() * scratch_;

  const auto beyond = [&](Index direction, double limit_rad) {
    const double first_rad = first_half_rad_[direction] - before_rad_[direction];
    const double second_rad = second_half_rad_[direction] - before_rad_[direction];
    return first_rad * second_rad > 0 && std::abs(first_rad + second_rad) >= 2 * limit_rad &&
           std::min(std::abs(first_rad), std::abs(second_rad)) >= kShareOfHalf * limit_rad;
  };
  double most = 1;
  JointChange joint;
  bool any = false;
  for (Index k = 0; k < axes.cols(); ++k) {
    if (directions.eigenvalues()[k] >= missing_rad2) continue;
    const double limit = limit_rad(directions, k);
    const double along_rad = 0.5 * (first_half_rad_[k] + second_half_rad_[k]) - before_rad_[k];
    most = std::max(most, std::abs(along_rad) / limit);
    any = any || beyond(k, limit);
    joint.add(along_rad / usual_.along_rad(axes.col(k)));
  }
  any = any && joint.beyond(settings_.joint_gate);
  const bool expression = any && !is_displacement(change_rad_);
  if (expression && rests_s_ <= 0) {
    jump_.drop();
    const double offset_norm_rad = offset_rad_.norm();
    const bool settled = shifted_ > 0 && held_s_ > static_cast<double>(kWindow);
    for (Index k = 0; k < axes.cols(); ++k) {
      if (directions.eigenvalues()[k] >= missing_rad2) continue;
      const double limit = kShareOfOthers * limit_rad(directions, k);
      if (!beyond(k, limit)) continue;
      direction_ = axes.col(k);
      shift(direction_, before_rad_[k], 0.5 * (first_half_rad_[k] + second_half_rad_[k]), limit);
    }
    const bool back = second_half_rad_.norm() < kAllBackShare * before_rad_.norm();
    if (shifted_ == 0 || (settled && back)) {
      drop();
    } else if (settled && change_rad_.norm() > kAnotherShare * offset_norm_rad) {
      // Another level rather than the one before: here they come and go, and tell nothing of drift.
      drop();
      rests_s_ = settings_.rest_s;
    }
  }
  // What is held counts among the usual changes for no more than its limit.
  change_rad_ /= most;
  usual_.add(change_rad_);
  if (any && !expression) interrupt();
}

void LevelShift::add(double dt_s, const Eigen::VectorXd& deviation_rad, const Directions& directions,
                     double missing_rad2) {
  if (settings_.gate <= 0) return;
  sum_rad_ += dt_s * (deviation_rad + total_rad_);
  sum_s_ += dt_s;
  follow(dt_s, deviation_rad);
  jump_.follow(dt_s, deviation_rad);
  total_rad_ = offset_rad_ + jump_.offset_rad();
  if (sum_s_ < 1) return;
  end_second();
  if (seconds_ >= LevelJump::kLast + LevelJump::kBefore)
    jump_.look(seconds_rad_, offset_rad_, directions, missing_rad2, rests_s_ <= 0);
  if (seconds_ >= seconds_rad_.cols()) detect(directions, missing_rad2);
  total_rad_ = offset_rad_ + jump_.offset_rad();
}

}  // namespace mien::imu
