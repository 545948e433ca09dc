#include "mien/imu/rest_measurement.h"

#include <algorithm>
#include <cmath>

namespace mien::imu {

void RestMeasurement::begin() {
  std::ranges::fill(sensors_, Sensor());
  frames_ = 0;
  up_ = Vec3::Zero();
}

void RestMeasurement::add(std::span<const std::optional<Vec3>> turn_rad, const Vec3& up) {
  ++frames_;
  up_ += up;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    if (!turn_rad[i]) continue;
    Sensor& sensor = sensors_[i];
    const Quat turn = exp_rotation(*turn_rad[i]);
    if (sensor.frames++ == 0) sensor.first = turn;
    const Vec3 since_rad = log_rotation(sensor.first.conjugate() * turn);
    sensor.sum_rad += since_rad;
    sensor.sum_rad2 += since_rad.squaredNorm();
  }
}

std::optional<Vec3> RestMeasurement::turn_rad(std::size_t sensor) const {
  const Sensor& one = sensors_[sensor];
  if (one.frames == 0 || 2 * one.frames < frames_) return std::nullopt;
  return log_rotation(one.first * exp_rotation(one.sum_rad / static_cast<double>(one.frames)));
}

double RestMeasurement::scatter_rad(std::size_t sensor) const {
  const Sensor& one = sensors_[sensor];
  if (one.frames == 0) return 0;
  const auto frames = static_cast<double>(one.frames);
  return std::sqrt(std::max(0.0, one.sum_rad2 / frames - (one.sum_rad / frames).squaredNorm()));
}

}  // namespace mien::imu
