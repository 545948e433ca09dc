#include "mien/imu/fusion.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "mien/core/covariance.h"
#include "mien/imu/heading.h"

namespace mien::imu {
namespace {

/// While a wearer was asked to hold still, rest_min_s and the rest thresholds are multiplied by these.
constexpr double kExpectedRestTime = 1.0 / 3;
constexpr double kExpectedRestTolerance = 2.0;
/// A step longer than this many times the one before is a gap.
constexpr double kGapSteps = 2.5;
/// So many gaps one after the other, whose lengths differ by less than this share, are a board that samples
/// more slowly than before.
constexpr int kGapsOfARate = 8;
constexpr double kAlike = 0.25;
/// Rates last for so long, s; after that they are taken as a process of this correlation time, s.
constexpr double kRateLasts_s = 0.04, kRateCorrelation_s = 0.08;
/// A gap hides this share of the mean of its end rates, and of their difference.
constexpr double kHiddenOfMean = 0.25, kHiddenOfChange = 0.2;

/// 1 - exp(-dt / tau): how much of a step a first-order low-pass follows.
double gain(double dt_s, double tau_s) {
  if (tau_s <= 0) return 1;
  return 1 - std::exp(-dt_s / tau_s);
}

/// The turn between two samples from the rates at both: mean rate, and the first coning term.
/// Source: Magnus expansion for a rate linear in time.
Vec3 turn_between(const Vec3& rate0, const Vec3& rate1, double dt_s) {
  return 0.5 * dt_s * (rate0 + rate1) + (dt_s * dt_s / 12) * rate0.cross(rate1);
}

/// The time over which the mean of a gap's end rates is integrated, s. Heads and skin turn back and forth, so
/// beyond a moment the rate is an Ornstein-Uhlenbeck process pinned at both ends: the integral of its mean.
double effective_time(double gap_s) {
  if (gap_s <= kRateLasts_s) return gap_s;
  return kRateLasts_s + 2 * kRateCorrelation_s * std::tanh(0.5 * (gap_s - kRateLasts_s) / kRateCorrelation_s);
}

/// After a long gap the inclination that its end rates tell counts for as much time of forces as its variance
/// times that time is this, rad^2 s (5 deg: 0.6 s), at most so long, s.
constexpr double kPrior_rad2_s = 0.0046, kMostPrior_s = 6;

/// How much of what a gap can hide it does, 0 to 1: within a few hundredths of a second rates
/// hardly turn. Fitted to gaps of 21 to 254 ms in virtual performances (docs/method/fusion.md).
double hidden_share(double gap_s) {
  constexpr double kTurning_s = 0.07;
  return 1 - std::exp(-gap_s / kTurning_s);
}

/// The full-scale range, rad/s, at whose end an axis reads; 0 where none does. Samples do not carry their
/// range, but packets allow only these (docs/reference/protocol.md), and a chip that clips reports full
/// scale. The smaller ranges are left out: no face reaches their ends on purpose. One valid reading in ten
/// thousand lies on such an end by chance, and costs a little certainty.
double clipped_range(const Vec3& gyro_rad_s) {
  const double most = gyro_rad_s.cwiseAbs().maxCoeff() * 180 / std::numbers::pi;
  for (const double range : {256.0, 512.0, 1024.0, 2048.0})
    if (most >= range * (1 - 1.5 / 32768) && most <= range * (1 + 1e-5))
      return range * std::numbers::pi / 180;
  return 0;
}

}  // namespace

template <int N>
const typename LowPass<N>::Vector& LowPass<N>::add(double dt_s, const Vector& value) {
  elapsed_s_ += dt_s;
  if (elapsed_s_ <= tau_s_) {
    sum_ += value;
    count_ += 1;
    value_ = sum_ / count_;
    band_.setZero();
    low_ = value_;
    return value_;
  }
  if (count_ == 0) low_ = value;  // The first step is longer than tau.
  count_ += 1;
  if (dt_s != dt_s_) {
    dt_s_ = dt_s;
    const double g = std::tan(std::min(dt_s / (std::numbers::sqrt2 * tau_s_), 1.5));
    a1_ = 1 / (1 + g * (g + std::numbers::sqrt2));
    a2_ = g * a1_;
    a3_ = g * a2_;
  }
  const Vector high = value - low_;
  const Vector band = a1_ * band_ + a2_ * high;
  value_ = low_ + a2_ * band_ + a3_ * high;
  band_ = 2 * band - band_;
  low_ = 2 * value_ - low_;
  return value_;
}

template class LowPass<2>;
template class LowPass<3>;
template class LowPass<9>;

Fusion::Fusion(const FusionSettings& settings)
    : settings_(settings),
      force_(settings.tau_accel_s),
      rest_gyro_(settings.rest_filter_tau_s),
      rest_accel_(settings.rest_filter_tau_s),
      quick_gyro_(settings.rest_noise_tau_s),
      quick_accel_(settings.rest_noise_tau_s),
      rotation_(settings.tau_accel_s),
      rotated_bias_(settings.tau_accel_s),
      bias_cov_(Mat3::Identity() * settings.bias_sigma_init_rad_s * settings.bias_sigma_init_rad_s),
      mag_{.current = LowPass<2>(settings.mag_current_tau_s)} {}

Quat Fusion::orientation() const {
  const Quat q = q_accel_ * q_gyro_;
  return heading_ == 0 ? q : Quat(Eigen::AngleAxisd(heading_, Vec3::UnitY())) * q;
}

double Fusion::bias_sigma_rad_s() const {
  return std::sqrt(bias_cov_.diagonal().maxCoeff());
}

void Fusion::add(double dt_s, const Vec3& gyro_rad_s, const Vec3& accel_m_s2) {
  const bool gap = last_dt_s_ > 0 && dt_s > kGapSteps * last_dt_s_;
  if (!started_) {
    // The first force initialises the inclination.
    started_ = true;
    dt_s = 0;
    last_raw_ = gyro_rad_s;
  } else if (gap) {
    // Standard deviation of the angle between the two ends of the gap, an axis.
    const double hidden_rad_s =
        std::hypot(kHiddenOfMean * 0.5 * (gyro_rad_s + last_raw_).norm(),
                   kHiddenOfChange * (gyro_rad_s - last_raw_).norm(), settings_.unseen_rate_rad_s);
    const double change = hidden_rad_s * dt_s * hidden_share(dt_s);
    gap_sigma_ = std::hypot(gap_sigma_, change);
    if (dt_s > settings_.max_gap_s) {
      // A head turns where it likes: within ten seconds to anywhere.
      gap_sigma_ = std::hypot(gap_sigma_, std::numbers::pi * std::min(1.0, dt_s / 10));
      ++restarts_;
      force_.restart(std::min(kMostPrior_s, kPrior_rad2_s / (change * change)) / last_dt_s_);
      rotation_.restart();
      rotated_bias_.restart();
      rest_gyro_.restart();
      rest_accel_.restart();
      quick_gyro_.restart();
      quick_accel_.restart();
      rest_s_ = 0;
      at_rest_ = false;
    }
  }
  alike_gaps_ = gap && std::abs(dt_s - last_gap_s_) < kAlike * dt_s ? alike_gaps_ + 1 : 0;
  if (gap) last_gap_s_ = dt_s;
  if (dt_s > 0 && (!gap || alike_gaps_ >= kGapsOfARate)) last_dt_s_ = dt_s;

  if (const double range = clipped_range(gyro_rad_s); range > 0) {
    // Consecutive clipped samples err in the same direction: their errors add linearly, not in squares.
    const double before = clipped_rad_;
    clipped_rad_ += settings_.clip_excess * range * dt_s;
    gap_sigma_ = std::sqrt(gap_sigma_ * gap_sigma_ + clipped_rad_ * clipped_rad_ - before * before);
  } else {
    clipped_rad_ = 0;
  }
  last_rate_ = gyro_rad_s - bias_;
  const Vec3 rate_before = settings_.gyro_is_step_mean ? last_rate_ : Vec3(last_raw_ - bias_);
  q_gyro_ = q_gyro_ * exp_rotation(turn_between(rate_before, last_rate_, gap ? effective_time(dt_s) : dt_s));
  q_gyro_.normalize();
  last_raw_ = gyro_rad_s;

  // The filters need a step; the first sample gets a nominal one.
  const double step_s = dt_s > 0 ? dt_s : 1e-3;
  detect_rest(gap ? last_dt_s_ : step_s, gyro_rad_s, accel_m_s2);
  correct_inclination(gap || dt_s == 0 ? std::numeric_limits<double>::infinity() : step_s, accel_m_s2);
}

void Fusion::restart() {
  Fusion anew(settings_);
  anew.bias_ = bias_;
  anew.bias_cov_ = bias_cov_;
  anew.restarts_ = restarts_ + 1;
  anew.on_skin_ = on_skin_;
  *this = anew;
}

void Fusion::detect_rest(double dt_s, const Vec3& gyro, const Vec3& accel) {
  const double tolerance = rest_expected_ ? kExpectedRestTolerance : 1.0;
  const Vec3& gyro_mean = rest_gyro_.add(dt_s, gyro);
  const Vec3& accel_mean = rest_accel_.add(dt_s, accel);
  const Vec3& quick_gyro = quick_gyro_.add(dt_s, gyro);
  const Vec3& quick_accel = quick_accel_.add(dt_s, accel);
  // Slow even motion looks like rest with another bias: gated by the bias's uncertainty, unless the wearer
  // was asked to hold still.
  const double gate = rest_expected_ ? settings_.rest_bias_clip_rad_s
                                     : std::max(3 * bias_sigma_rad_s(), settings_.rest_bias_tolerance_rad_s);
  const bool moving = (quick_gyro - gyro_mean).norm() > tolerance * settings_.rest_gyro_rad_s ||
                      (quick_accel - accel_mean).norm() > tolerance * settings_.rest_accel_m_s2 ||
                      gyro_mean.cwiseAbs().maxCoeff() > settings_.rest_bias_clip_rad_s ||
                      (gyro_mean - bias_).cwiseAbs().maxCoeff() > gate;
  rest_s_ = moving ? 0 : rest_s_ + dt_s;
  at_rest_ = rest_s_ >= settings_.rest_min_s * (rest_expected_ ? kExpectedRestTime : 1.0);
}

void Fusion::correct_inclination(double dt_s, const Vec3& accel) {
  if (accel.squaredNorm() < 1e-6) return;  // Free fall: the vertical is not observable.
  const bool step_known = std::isfinite(dt_s);
  const double filter_dt_s = step_known ? dt_s : std::max(last_dt_s_, 1e-3);
  const Vec3 up = (q_accel_ * force_.add(filter_dt_s, q_gyro_ * accel)).normalized();
  // The shortest turn that brings `up` to +Y.
  const double w = std::sqrt(std::max(0.0, 0.5 * (up.y() + 1)));
  const Quat correction = w > 1e-6 ? Quat(w, -0.5 * up.z() / w, 0, 0.5 * up.x() / w) : Quat(0, 1, 0, 0);
  q_accel_ = correction * q_accel_;
  q_accel_.normalize();
  if (step_known) estimate_bias(dt_s, (q_accel_ * q_gyro_).toRotationMatrix(), up);
}

void Fusion::estimate_bias(double dt_s, const Mat3& rotation, const Vec3& error_up) {
  // Rotation and rotated bias pass the force's low-pass too, so that the innovation compares equal delays.
  const Vec3 rotated = rotation * bias_;
  const Eigen::Vector2d delayed_bias = rotated_bias_.add(dt_s, Eigen::Vector2d(rotated.x(), rotated.z()));
  Eigen::Matrix<double, 9, 1> flat;
  flat << rotation.row(0).transpose(), rotation.row(1).transpose(), rotation.row(2).transpose();
  const Eigen::Matrix<double, 9, 1>& delayed = rotation_.add(dt_s, flat);

  constexpr double kForgettingRate =
      0.1 * std::numbers::pi / 180;  // What bias_forgetting_s refers to: 0.1 deg/s.
  const double spread = kForgettingRate * kForgettingRate * dt_s / settings_.bias_forgetting_s;
  const double start = settings_.bias_sigma_init_rad_s * settings_.bias_sigma_init_rad_s;
  for (Eigen::Index i = 0; i < 3; ++i)
    if (bias_cov_(i, i) < start) bias_cov_(i, i) += spread;
  // The measurement's variance that makes the estimate converge to a sigma: p^2 / V + p.
  const auto weight = [spread](double sigma) {
    const double p = sigma * sigma;
    return p * p / spread + p;
  };

  Mat3 observed;
  Vec3 error;
  Vec3 variance;
  if (at_rest_ && (rest_expected_ || !on_skin_)) {
    observed = Mat3::Identity();
    error = rest_gyro_.value() - bias_;
    variance = Vec3::Constant(weight(settings_.bias_sigma_rest_rad_s));
  } else if (!at_rest_) {
    for (Eigen::Index row = 0; row < 3; ++row) observed.row(row) = delayed.segment<3>(3 * row).transpose();
    error = -(observed * bias_);
    // The inclination correction of one step, as a rate, is the bias seen in the world's horizontal axes. The
    // vertical row is an artificial zero measurement (bias_vertical_forgetting).
    error.x() += error_up.z() / dt_s + delayed_bias.x();
    error.z() += -error_up.x() / dt_s + delayed_bias.y();
    const double horizontal = weight(settings_.bias_sigma_motion_rad_s);
    variance = Vec3(horizontal, horizontal / std::max(settings_.bias_vertical_forgetting, 1e-10), horizontal);
  } else {
    return;
  }
  const double clip = at_rest_ ? settings_.rest_bias_clip_rad_s : settings_.bias_clip_rad_s;
  error = error.cwiseMax(-clip).cwiseMin(clip);
  const Mat3 innovation = Mat3(variance.asDiagonal()) + observed * bias_cov_ * observed.transpose();
  const Mat3 kalman = bias_cov_ * observed.transpose() * innovation.inverse();
  bias_ += kalman * error;
  update_covariance<3, 3>(bias_cov_, observed, kalman, variance.asDiagonal());
  bias_ = bias_.cwiseMax(-settings_.rest_bias_clip_rad_s).cwiseMin(settings_.rest_bias_clip_rad_s);
}

void Fusion::fuse_mag(const Vec3& mag) {
  const double norm = mag.norm();
  if (!(norm > 0)) return;
  const double dt_s = last_dt_s_ > 0 ? last_dt_s_ : 1e-3;
  const Vec3 field = q_accel_ * (q_gyro_ * mag);
  MagState& m = mag_;

  const Eigen::Vector2d current =
      m.current.add(dt_s, Eigen::Vector2d(norm, -std::asin(std::clamp(field.y() / norm, -1.0, 1.0))));
  m.norm = current.x();
  m.dip = current.y();
  const auto near = [this, &m](double other_norm, double other_dip) {
    return std::abs(m.norm - other_norm) < settings_.mag_norm_tolerance * other_norm &&
           std::abs(m.dip - other_dip) < settings_.mag_dip_tolerance_rad;
  };
  const double follow = gain(dt_s, settings_.mag_reference_tau_s);
  if (near(m.reference_norm, m.reference_dip)) {
    m.undisturbed_s += dt_s;
    if (m.undisturbed_s >= settings_.mag_min_undisturbed_s) {
      m.disturbed = false;
      m.reference_norm += follow * (m.norm - m.reference_norm);
      m.reference_dip += follow * (m.dip - m.reference_dip);
    }
  } else {
    m.undisturbed_s = 0;
    m.disturbed = true;
  }
  // Another homogeneous field, held while the sensor turns, becomes the new reference.
  if (near(m.candidate_norm, m.candidate_dip)) {
    if (last_rate_.norm() >= settings_.mag_new_min_gyro_rad_s) m.candidate_s += dt_s;
    m.candidate_norm += follow * (m.norm - m.candidate_norm);
    m.candidate_dip += follow * (m.dip - m.candidate_dip);
    const bool first = m.reference_norm == 0;
    if (m.disturbed && m.candidate_s >= (first ? settings_.mag_new_first_s : settings_.mag_new_s)) {
      m.reference_norm = m.candidate_norm;
      m.reference_dip = m.candidate_dip;
      m.disturbed = false;
      m.undisturbed_s = settings_.mag_min_undisturbed_s;
    }
  } else {
    m.candidate_s = 0;
    m.candidate_norm = m.norm;
    m.candidate_dip = m.dip;
  }

  double k = gain(dt_s, settings_.tau_mag_s);
  if (m.disturbed) {
    if (m.rejected_s <= settings_.mag_max_rejection_s) {
      m.rejected_s += dt_s;
      k = 0;
    } else {
      k /= settings_.mag_rejection_factor;
    }
  } else {
    m.rejected_s = std::max(0.0, m.rejected_s - settings_.mag_rejection_factor * dt_s);
  }
  // The first readings are averaged: 1, 1/2, 1/3, ... until that is slower than the filter.
  if (m.start_gain > 0) {
    k = std::max(k, m.start_gain);
    m.start_gain = m.start_gain / (m.start_gain + 1);
    if (m.start_gain * settings_.tau_mag_s < dt_s) m.start_gain = 0;
  }
  heading_ = wrap_heading(heading_ + k * wrap_heading(-std::atan2(field.x(), field.z()) - heading_));
}

}  // namespace mien::imu
