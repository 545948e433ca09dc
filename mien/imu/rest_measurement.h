#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/rotation.h"

namespace mien::imu {

/// Settings of a rest that a person asks for. Defaults: docs/method/fusion.md, "A rest that is asked for".
struct RestSettings {
  /// How far a resting face's skin is from the calibration's neutral, a standard deviation an axis, rad (1
  /// deg). Raising: the rest corrects less. Lowering: an expression at rest is taken for drift.
  double sigma_rad = 0.0175;
  /// A sensor whose rotation scatters by more than this over the rest, RMS, has moved, and is not corrected,
  /// rad (1.5 deg). Raising: speech can be taken for rest. Lowering: blinks and swallowing spoil it.
  double moved_rad = 0.026;
};

/// Mean rotation of each face sensor over a rest, frame by frame. Thread: one at a time. No allocation after
/// construction.
class RestMeasurement {
 public:
  explicit RestMeasurement(std::size_t face_sensors) : sensors_(face_sensors) {}

  void begin();
  /// One frame. Shape: an entry a face sensor. `turn_rad`: E_i as rotation vectors, frame H, rad; none where
  /// it is missing. `up`: the vertical, unit, frame H.
  void add(std::span<const std::optional<Vec3>> turn_rad, const Vec3& up);
  /// A frame without any rotation.
  void pass() { ++frames_; }
  /// The sensor's rotations before are of other states: its measurement begins anew.
  void forget(std::size_t sensor) { sensors_[sensor] = {}; }

  /// Mean of E_i, frame H, rad; none where it was there for less than half of the frames.
  [[nodiscard]] std::optional<Vec3> turn_rad(std::size_t sensor) const;
  /// RMS angle from that mean, rad; 0 where nothing was measured.
  [[nodiscard]] double scatter_rad(std::size_t sensor) const;
  /// Mean of the vertical, unit.
  [[nodiscard]] Vec3 up() const { return up_.normalized(); }

 private:
  struct Sensor {
    std::size_t frames = 0;
    Quat first = Quat::Identity();  // Of its first frame; the sums are of rotations from there.
    Vec3 sum_rad = Vec3::Zero();
    double sum_rad2 = 0;
  };
  std::vector<Sensor> sensors_;
  std::size_t frames_ = 0;
  Vec3 up_ = Vec3::UnitY();  // Sum.
};

}  // namespace mien::imu
