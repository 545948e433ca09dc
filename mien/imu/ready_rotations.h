#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/core/time.h"
#include "mien/model/features.h"
#include "mien/sensor/sample.h"

namespace mien::imu {

/// Skin rotations that need neither fusion nor calibration: samples of the kind imu_head_relative, which
/// takes of the profile "lab" have and no device sends. They pass the pipeline by.
class ReadyRotations {
 public:
  /// `face`: the rig's numbers of the face sensors, in the order of the features. `silence`: a sensor without
  /// a sample so near to a frame is missing; raised, gaps are bridged for longer by what no longer holds.
  ReadyRotations(std::span<const std::uint16_t> face, Duration silence);

  /// Samples of other kinds and sensors, short ones and those that are not finite are ignored.
  void add(const sensor::Sample& sample);
  void forget(std::uint16_t sensor);
  /// Puts each sensor's rotation in place of what `out` has of it, frame H; of sensors without samples
  /// nothing changes. It is that of the nearest sample and not interpolated: the mean of two would halve the
  /// variance of the noise that the profile adds.
  void put(DeviceTime frame, model::FeatureFrame& out) const;

 private:
  struct Entry {
    DeviceTime time;
    Vec3 rotation_vector = Vec3::Zero();
  };
  /// The newest of one sensor, a ring.
  struct Sensor {
    std::uint16_t number = 0;
    std::array<Entry, 16> entries;
    std::size_t added = 0;
  };
  std::vector<Sensor> sensors_;
  Duration silence_;
};

}  // namespace mien::imu
