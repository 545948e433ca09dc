#include "mien/imu/heading.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace mien::imu {
namespace {

constexpr double kPi = std::numbers::pi;
/// Errors of successive nods are correlated: independent measurements that a prologue counts for.
constexpr double kIndependentLooks = 2;
/// Indices in the state: the wearer-specific skin rotation, its turn about the vertical, and the creep.
constexpr Eigen::Index kWearer = 2, kWearerY = 3, kSlip = 5;
/// Chi-square quantile of three degrees of freedom over that of one, at the probability of 2.5 sigmas.
constexpr double kThreeNumbers = 1.74;

double wrap_heading(double angle) {
  const double wrapped = std::remainder(angle, 2 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

}  // namespace

Quat heading_turn(double angle_rad) {
  return Quat(Eigen::AngleAxisd(angle_rad, Vec3::UnitY()));
}

void HeadingSums::add(const Quat& q_world_ear, const Quat& q_world_face) {
  const Mat3 ear = q_world_ear.toRotationMatrix().transpose();
  const Mat3 face = q_world_face.toRotationMatrix();
  // Z = y y^T + cos (1 - y y^T) + sin [y]x, with [y]x face = (row z, 0, -row x).
  const Mat3 vertical = ear.col(1) * face.row(1);
  constant_ += vertical;
  cosine_ += ear * face - vertical;
  sine_ += ear.col(0) * face.row(2) - ear.col(2) * face.row(0);
  up_sum_ += ear.col(1);
  ++count_;
}

HeadingSums& HeadingSums::operator+=(const HeadingSums& other) {
  constant_ += other.constant_;
  cosine_ += other.cosine_;
  sine_ += other.sine_;
  up_sum_ += other.up_sum_;
  count_ += other.count_;
  return *this;
}

double HeadingSums::squared_sum(double heading_rad) const {
  return (constant_ + std::cos(heading_rad) * cosine_ + std::sin(heading_rad) * sine_).squaredNorm();
}

Quat HeadingSums::mean(double heading_rad) const {
  // The rotation closest to the sum of matrices: fit_rotation takes the transpose, "from" to "to".
  const Mat3 sum = constant_ + std::cos(heading_rad) * cosine_ + std::sin(heading_rad) * sine_;
  return fit_rotation(Mat3(sum.transpose()));
}

double HeadingSums::spread(double heading_rad) const {
  if (count_ == 0) return 0;
  // Sum |P - mean|_F^2 = 3 n - |sum P|^2 / n, and a turn by an angle a is 2 a^2 of it.
  const double n = static_cast<double>(count_);
  return std::sqrt(std::max(0.0, 0.5 * (3.0 - squared_sum(heading_rad) / (n * n))));
}

HeadingSums::Best HeadingSums::find() const {
  Best best;
  best.sigma_rad = kPi;
  if (count_ < 2) return best;
  // The sum of squares is a trigonometric polynomial of degree two: coarse search, then golden section.
  constexpr int kCoarse = 72;
  double top = -1;
  for (int i = 0; i < kCoarse; ++i) {
    const double angle = wrap_heading(2 * kPi * i / kCoarse);
    const double value = squared_sum(angle);
    if (value > top) {
      top = value;
      best.heading_rad = angle;
    }
  }
  double low = best.heading_rad - 2 * kPi / kCoarse;
  double high = best.heading_rad + 2 * kPi / kCoarse;
  constexpr double kGolden = 0.6180339887498949;
  for (int i = 0; i < 60; ++i) {
    const double a = high - kGolden * (high - low);
    const double b = low + kGolden * (high - low);
    (squared_sum(a) > squared_sum(b) ? high : low) = squared_sum(a) > squared_sum(b) ? b : a;
  }
  best.heading_rad = wrap_heading(0.5 * (low + high));
  const double n = static_cast<double>(count_);
  const double tilt2 = 1 - (up_sum_ / n).squaredNorm();  // Mean square path of the vertical about its mean.
  const double left = std::max(spread(best.heading_rad), 1e-4);
  if (tilt2 > 1e-9) best.sigma_rad = std::min(kPi, left / std::sqrt(tilt2 * kIndependentLooks));
  return best;
}

void HeadingTracker::start(double heading_rad, double sigma_rad,
                           const std::optional<Mat3>& residual_cov_rad2) {
  *this = HeadingTracker(settings_);
  move_to(heading_rad, sigma_rad);
  if (residual_cov_rad2)
    cov_.block<3, 3>(kWearer, kWearer) =
        settings_.wearer_rotation_sigmas * settings_.wearer_rotation_sigmas * *residual_cov_rad2;
  else
    cov_(kWearerY, kWearerY) = settings_.rest_sigma_rad * settings_.rest_sigma_rad;
}

void HeadingTracker::move_to(double heading_rad, double sigma_rad) {
  heading_ = heading_rad;
  rate_ = 0;
  cov_.topRows<kWearer>().setZero();
  cov_.leftCols<kWearer>().setZero();
  cov_(0, 0) = sigma_rad * sigma_rad;
  cov_(1, 1) = settings_.rate_sigma_rad_s * settings_.rate_sigma_rad_s;
  still_s_ = 0;
  lost_s_ = 0;
}

double HeadingTracker::sigma_rad() const {
  return std::min(kPi, std::sqrt(std::max(0.0, cov_(0, 0))));
}

void HeadingTracker::predict(double dt_s) {
  heading_ = wrap_heading(heading_ + rate_ * dt_s);
  const double keep = std::exp(-dt_s / settings_.rate_tau_s);
  rate_ *= keep;
  // Covariance: F P F^T, of which one half is computed, then the process noise.
  cov_(0, 0) += dt_s * (2 * cov_(1, 0) + dt_s * cov_(1, 1));
  cov_(1, 0) = keep * (cov_(1, 0) + dt_s * cov_(1, 1));
  cov_(1, 1) *= keep * keep;
  for (Eigen::Index i = kWearer; i < kStates; ++i) {
    cov_(i, 0) += dt_s * cov_(i, 1);
    cov_(i, 1) *= keep;
  }
  cov_.row(0) = cov_.col(0).transpose();
  cov_.row(1) = cov_.col(1).transpose();
  cov_(0, 0) += settings_.heading_walk * settings_.heading_walk * dt_s;
  cov_(1, 1) += settings_.rate_walk * settings_.rate_walk * dt_s;
  cov_.diagonal().segment<3>(kSlip).array() += settings_.slip_walk * settings_.slip_walk * dt_s;
}

void HeadingTracker::begin(const Quat& q_ear_face) {
  stretch_s_ = 0;
  n_ = 0;
  from_ = q_ear_face;
  world_sum_.setZero();
  turn_sum_.setZero();
  world_turn_sum_.setZero();
  turn_turn_ = 0;
}

void HeadingTracker::skip(double dt_s) {
  predict(dt_s);
  still_s_ = 0;
  lost_s_ = 0;
}

void HeadingTracker::move_by(const StateVec& change) {
  // The error states are estimate less truth, so they are subtracted.
  heading_ = wrap_heading(heading_ - change[0]);
  rate_ -= change[1];
  wearer_rotation_ += change.segment<3>(kWearer);
  slip_ += change.segment<3>(kSlip);
}

void HeadingTracker::correct(const StateVec& observation, double innovation_rad, double sigma_rad) {
  const StateVec spread = cov_ * observation;
  const double noise_rad2 = sigma_rad * sigma_rad;
  const StateVec kalman = spread / (observation.dot(spread) + noise_rad2);
  move_by(kalman * innovation_rad);
  update_covariance<kStates, 1>(cov_, observation.transpose(), kalman,
                                Eigen::Matrix<double, 1, 1>(noise_rad2));
}

bool HeadingTracker::recover_lost_heading(double dt_s, double turn_rad, double wearer_rad) {
  const bool away = std::abs(turn_rad) > settings_.lost_turn_rad && sigma_rad() > settings_.lost_sigma_rad;
  if (!away || turn_rad * lost_least_rad_ < 0) lost_s_ = 0;
  if (!away) return false;
  if (lost_s_ == 0 || std::abs(turn_rad) < std::abs(lost_least_rad_)) {
    lost_least_rad_ = turn_rad;
    lost_wearer_rad_ = wearer_rad;
  }
  lost_s_ += dt_s;
  if (lost_s_ <= settings_.lost_after_s) return false;
  heading_ = wrap_heading(heading_ - (lost_least_rad_ - lost_wearer_rad_));
  lost_s_ = 0;
  still_s_ = 0;  // The current stretch is about the heading before.
  return true;
}

void HeadingTracker::add_turn_from_neutral(double dt_s, double turn_rad, double tilt_rad) {
  const double wearer_rad = wearer_rotation_.y();
  if (settings_.neutral_sigma_rad <= 0 || dt_s <= 0 || recover_lost_heading(dt_s, turn_rad, wearer_rad))
    return;
  const double skin_sigma_rad = std::hypot(settings_.neutral_sigma_rad, settings_.neutral_tilt * tilt_rad);
  // The turn is the heading error plus where the skin rests.
  const StateVec observation = StateVec::Unit(0) + StateVec::Unit(kWearerY);
  const double innovation_rad = turn_rad - wearer_rad;
  const double expected2 = observation.dot(cov_ * observation) + skin_sigma_rad * skin_sigma_rad;
  if (innovation_rad * innovation_rad > settings_.neutral_gate * settings_.neutral_gate * expected2) return;
  correct(observation, innovation_rad, skin_sigma_rad * std::sqrt(settings_.neutral_every_s / dt_s));
}

void HeadingTracker::add_skin(double dt_s, const SkinMeasurement& measurement) {
  if (settings_.neutral_sigma_rad <= 0 || dt_s <= 0) return;
  // The heading error if the skin turned exactly as predicted, and the wearer's part of it.
  const Vec3 weighed = measurement.residual_cov_rad2.inverse() * measurement.heading_jacobian;
  const double whole = weighed.dot(measurement.heading_jacobian);
  if (recover_lost_heading(dt_s, weighed.dot(measurement.residual_rad) / whole,
                           measurement.strength * weighed.dot(wearer_rotation_) / whole))
    return;
  Eigen::Matrix<double, 3, kStates> observation = Eigen::Matrix<double, 3, kStates>::Zero();
  observation.col(0) = measurement.heading_jacobian;
  observation.middleCols<3>(kWearer) = measurement.strength * Mat3::Identity();
  observation.middleCols<3>(kSlip) = Mat3::Identity();
  const Eigen::Matrix<double, kStates, 3> spread = cov_ * observation.transpose();
  const Mat3 expected = observation * spread;
  const double sigmas = settings_.predicted_sigmas * measurement.strength;
  const Mat3 noise = sigmas * sigmas * measurement.residual_cov_rad2;
  const Vec3 innovation = measurement.residual_rad - measurement.strength * wearer_rotation_;
  const double distance2 = innovation.dot(Mat3(expected + noise).inverse() * innovation);
  if (distance2 > kThreeNumbers * settings_.neutral_gate * settings_.neutral_gate) return;
  const Mat3 of_frames = noise * (settings_.predicted_every_s / dt_s);
  const Eigen::Matrix<double, kStates, 3> kalman = spread * Mat3(expected + of_frames).inverse();
  move_by(kalman * innovation);
  update_covariance<kStates, 3>(cov_, observation, kalman, of_frames);
}

void HeadingTracker::add(double dt_s, const Quat& q_ear_face, const Quat& q_world_ear, const Vec3& rate_rad_s,
                         const Vec3& head_rate_rad_s) {
  predict(dt_s);
  smooth_rate_ += std::min(1.0, dt_s / 0.1) * (rate_rad_s - smooth_rate_);
  if (smooth_rate_.norm() > settings_.still_rad_s + settings_.still_share * head_rate_rad_s.norm()) {
    still_s_ = 0;
    return;
  }
  const bool was_still = still_s_ >= settings_.still_s;
  still_s_ += dt_s;
  if (still_s_ < settings_.still_s) return;
  if (!was_still || stretch_s_ > settings_.max_stretch_s) begin(q_ear_face);

  const Vec3 turn = log_rotation(q_ear_face * from_.conjugate());
  const Mat3 world_ear = q_world_ear.toRotationMatrix();
  stretch_s_ += dt_s;
  n_ += 1;
  world_sum_ += world_ear;
  turn_sum_ += turn;
  world_turn_sum_ += world_ear * turn;
  turn_turn_ += turn.squaredNorm();

  // Least squares of turn = R_h^T e + constant, the constant eliminated, the inclinations by their prior.
  const double frame2 = settings_.frame_sigma_rad * settings_.frame_sigma_rad * settings_.correlated_frames;
  const double hold = frame2 / (settings_.tilt_sigma_rad * settings_.tilt_sigma_rad);
  const Mat3 normal = Mat3(Mat3::Identity() * n_ - world_sum_ * world_sum_.transpose() / n_);
  Mat3 held = normal;
  held(0, 0) += hold;
  held(2, 2) += hold;
  // A pure turn about the vertical leaves the heading unobservable: a row of zeros, no inverse.
  if (normal(1, 1) < settings_.min_information) return;
  const Mat3 inverse = held.inverse();
  const double information = 1 / inverse(1, 1);
  if (!(information > settings_.min_information)) return;

  const Vec3 right = world_turn_sum_ - world_sum_ * turn_sum_ / n_;
  const Vec3 error = inverse * right;
  const double all = turn_turn_ - turn_sum_.squaredNorm() / n_;
  const double residual2 = std::max(0.0, all - 2 * error.dot(right) + error.dot(normal * error)) / n_;
  if (residual2 < settings_.max_residual_rad * settings_.max_residual_rad) {
    const double noise2 = std::max(frame2, residual2 * settings_.correlated_frames);
    correct(StateVec::Unit(0), error.y(), std::sqrt(noise2 / information));
  }
  begin(q_ear_face);
}

}  // namespace mien::imu
