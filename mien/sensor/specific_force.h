#pragma once

#include <optional>

#include "mien/core/rotation.h"
#include "mien/sensor/sample.h"

namespace mien::sensor {

/// Specific force that an inertial sample measures, m/s^2, frame S; none of any other kind.
[[nodiscard]] inline std::optional<Vec3f> specific_force(const Sample& sample) {
  if (sample.kind == SampleKind::imu_raw) return Vec3f(sample.values[3], sample.values[4], sample.values[5]);
  if (sample.kind == SampleKind::imu_fused)
    return Vec3f(sample.values[4], sample.values[5], sample.values[6]);
  return std::nullopt;
}

}  // namespace mien::sensor
