#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/profile.h"
#include "mien/model/features.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::lab {

/// How far a rotation that was given lies from the truth, as a rotation vector in frame H, rad.
[[nodiscard]] Vec3 rotation_error(const model::SensorFeature& given, const Quat& truth);

/// How many of the face sensors' rotations a model was given, and how far they lie from the truth: what
/// sensing and calibration cost, whatever the model makes of it.
class ObservedRotations {
 public:
  explicit ObservedRotations(const sensor::Rig& rig);

  /// One frame. Shape: `features` of the rig's face sensors; `sites` of all of its sensors.
  void add(const model::FeatureFrame& features, const face::BlendshapeWeights& truth,
           std::span<const virt::SkinSite> sites);
  /// Others of the same rig.
  void add(const ObservedRotations& others);

  /// Share of the rotations that there could have been, 0 to 1.
  [[nodiscard]] double share() const;
  /// The same of one face sensor, by its place among them.
  [[nodiscard]] double share(std::size_t face_sensor) const;
  /// Error in the head frame, rad, RMS over all that were given.
  [[nodiscard]] double rms_rad() const;

 private:
  std::vector<std::uint16_t> face_sensors_;
  std::size_t frames_ = 0;
  std::vector<std::size_t> observed_;  // Frames with a rotation, a face sensor.
  double squares_rad2_ = 0;
};

}  // namespace mien::lab
