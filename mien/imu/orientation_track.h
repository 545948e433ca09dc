#pragma once

#include <cstdint>
#include <optional>

#include "mien/core/newest.h"
#include "mien/core/rotation.h"
#include "mien/core/time.h"

namespace mien::imu {

/// One fused sample, at the sensor's own device time.
struct FusedSample {
  DeviceTime time;
  Quat orientation = Quat::Identity();   ///< q_world_sensor, its fusion's world.
  Vec3 force_world_m_s2 = Vec3::Zero();  ///< Specific force in that fusion's world; +g along +Y at rest.
  Vec3 rate_rad_s = Vec3::Zero();        ///< Bias removed, frame S.
  double gap_sigma_rad = 0;              ///< Its fusion's, ...
  std::uint64_t restarts = 0;            ///< ... and the fusion's restarts, when it was made.
};

/// Ring buffer of one sensor's newest fused samples, with interpolation. No allocation.
class OrientationTrack {
 public:
  /// Times rise from call to call.
  void add(const FusedSample& sample) { samples_.push(sample); }
  void clear() { samples_.clear(); }
  /// Drops the samples later than `time`, which are fused anew and added again: all of them, before at() and
  /// reached() are asked.
  void drop_after(DeviceTime time);
  [[nodiscard]] bool empty() const { return samples_.empty(); }
  [[nodiscard]] const FusedSample& newest() const { return samples_[0]; }
  /// The oldest sample at or after `time` that is still there; the newest where none is. Not empty.
  [[nodiscard]] const FusedSample& reached(DeviceTime time) const;

  /// The sample at `time`: orientation and rate interpolated (slerp, linear) between samples; after the
  /// newest extrapolated by its rate for `prediction` at most, then held. The force is the mean over a 60th
  /// of a second about `time`. None where the newest sample before `time`, or the gap about it, is longer
  /// than `silence`.
  [[nodiscard]] std::optional<FusedSample> at(DeviceTime time, Duration silence, Duration prediction) const;

 private:
  [[nodiscard]] Vec3 force_around(DeviceTime time) const;

  Newest<FusedSample, 64> samples_;  // A quarter of a second at 240 Hz.
};

}  // namespace mien::imu
