#include "mien/study/imu/felt_rotations.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace mien::study {

FeltRotations::FeltRotations(const sensor::Rig& rig)
    : face_sensors_(rig.face_sensors()), felt_(face_sensors_.size(), 0) {}

void FeltRotations::add(const model::FeatureFrame& features, const face::BlendshapeWeights& truth,
                        std::span<const virt::SkinSite> sites) {
  ++frames_;
  for (std::size_t i = 0; i < face_sensors_.size(); ++i) {
    const model::SensorFeature& sensor = features.sensors[i];
    if (!sensor.has_rotation) continue;
    const auto& [w, x, y, z] = sensor.rotation;
    const Quat skin = sites[face_sensors_[i]].rotation(truth);
    squares_rad2_ += log_rotation(Quat(w, x, y, z) * skin.conjugate()).squaredNorm();
    ++felt_[i];
  }
}

void FeltRotations::add(const FeltRotations& others) {
  frames_ += others.frames_;
  for (std::size_t i = 0; i < felt_.size(); ++i) felt_[i] += others.felt_[i];
  squares_rad2_ += others.squares_rad2_;
}

double FeltRotations::share() const {
  const auto felt = std::accumulate(felt_.begin(), felt_.end(), std::size_t{0});
  return static_cast<double>(felt) / std::max(1.0, static_cast<double>(frames_ * felt_.size()));
}

double FeltRotations::share(std::size_t face_sensor) const {
  return static_cast<double>(felt_[face_sensor]) / std::max(1.0, static_cast<double>(frames_));
}

double FeltRotations::rms_rad() const {
  const auto felt = std::accumulate(felt_.begin(), felt_.end(), std::size_t{0});
  return std::sqrt(squares_rad2_ / std::max(1.0, static_cast<double>(felt)));
}

}  // namespace mien::study
