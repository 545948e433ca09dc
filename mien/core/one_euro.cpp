#include "mien/core/one_euro.h"

#include <cmath>
#include <numbers>

namespace mien {

double low_pass_share(double cutoff_hz, double step_s) {
  const double turn = 2 * std::numbers::pi * cutoff_hz * step_s;
  return turn > 0 ? 1 / (1 + 1 / turn) : 0;
}

double OneEuro::filter(DeviceTime time, double value) {
  if (!std::isfinite(value)) return value_;
  if (!begun_) {
    begun_ = true;
    time_ = time;
    value_ = value;
    return value_;
  }
  const double step_s = to_seconds(time - time_);
  if (step_s <= 0) return value_;
  time_ = time;
  const double speed = (value - value_) / step_s;
  speed_ += low_pass_share(settings_.derivative_cutoff_hz, step_s) * (speed - speed_);
  const double cutoff_hz = settings_.min_cutoff_hz + settings_.beta * std::abs(speed_);
  value_ += low_pass_share(cutoff_hz, step_s) * (value - value_);
  return value_;
}

Quat OneEuroRotation::filter(DeviceTime time, const Quat& value) {
  const double length = value.norm();
  if (!(std::abs(length - 1) < 0.1)) return value_;
  if (!begun_) {
    begun_ = true;
    time_ = time;
    value_ = canonical(value);
    return value_;
  }
  const double step_s = to_seconds(time - time_);
  if (step_s <= 0) return value_;
  time_ = time;
  const Vec3 way = log_rotation(value.normalized() * value_.conjugate());
  speed_ += low_pass_share(settings_.derivative_cutoff_hz, step_s) * (way / step_s - speed_);
  const double cutoff_hz = settings_.min_cutoff_hz + settings_.beta * speed_.norm();
  value_ = canonical(exp_rotation(low_pass_share(cutoff_hz, step_s) * way) * value_);
  return value_;
}

}  // namespace mien
