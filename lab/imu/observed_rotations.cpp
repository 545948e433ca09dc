#include "lab/imu/observed_rotations.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mien::lab {

Vec3 rotation_error(const model::SensorFeature& given, const Quat& truth) {
  const auto& [w, x, y, z] = given.rotation;
  return log_rotation(Quat(w, x, y, z) * truth.conjugate());
}

ObservedRotations::ObservedRotations(const sensor::Rig& rig)
    : face_sensors_(rig.face_sensors()), observed_(face_sensors_.size(), 0) {}

void ObservedRotations::add(const model::FeatureFrame& features, const face::BlendshapeWeights& truth,
                            std::span<const virt::SkinSite> sites) {
  ++frames_;
  for (std::size_t i = 0; i < face_sensors_.size(); ++i) {
    const model::SensorFeature& sensor = features.sensors[i];
    if (!sensor.has_rotation) continue;
    squares_rad2_ += rotation_error(sensor, sites[face_sensors_[i]].rotation(truth)).squaredNorm();
    ++observed_[i];
  }
}

void ObservedRotations::add(const ObservedRotations& others) {
  frames_ += others.frames_;
  for (std::size_t i = 0; i < observed_.size(); ++i) observed_[i] += others.observed_[i];
  squares_rad2_ += others.squares_rad2_;
}

double ObservedRotations::share() const {
  const auto observed = std::accumulate(observed_.begin(), observed_.end(), std::size_t{0});
  return static_cast<double>(observed) / std::max(1.0, static_cast<double>(frames_ * observed_.size()));
}

double ObservedRotations::share(std::size_t face_sensor) const {
  return static_cast<double>(observed_[face_sensor]) / std::max(1.0, static_cast<double>(frames_));
}

double ObservedRotations::rms_rad() const {
  const auto observed = std::accumulate(observed_.begin(), observed_.end(), std::size_t{0});
  return std::sqrt(squares_rad2_ / std::max(1.0, static_cast<double>(observed)));
}

}  // namespace mien::lab
