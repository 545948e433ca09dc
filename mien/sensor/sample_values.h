#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "mien/core/rotation.h"
#include "mien/sensor/sample.h"

// What is read from a sample of any device.
namespace mien::sensor {

/// Specific force that an inertial sample measures, m/s^2, frame S; none of any other kind.
[[nodiscard]] inline std::optional<Vec3f> specific_force(const Sample& sample) {
  if (sample.kind == SampleKind::imu_raw) return Vec3f(sample.values[3], sample.values[4], sample.values[5]);
  if (sample.kind == SampleKind::imu_fused)
    return Vec3f(sample.values[4], sample.values[5], sample.values[6]);
  return std::nullopt;
}

/// What a bar beside a sensor shows of a sample, 0 to 1, where its kind has one number that says how much the
/// sensor gets of what it is there for: of a photo-reflective one the light that came back from its own LED,
/// of a microphone its loudness, 0 at -60 dB of full scale and below.
[[nodiscard]] inline std::optional<float> level(const Sample& sample) {
  constexpr float kQuietest_db = -60;
  if (sample.kind == SampleKind::sound && sample.count >= 1)
    return std::clamp(1 - 20 * std::log10(std::max(1e-6F, sample.values[0])) / kQuietest_db, 0.0F, 1.0F);
  if (sample.kind != SampleKind::eyewear_light || sample.count < 2) return std::nullopt;
  return std::clamp(sample.values[0] - sample.values[1], 0.0F, 1.0F);
}

/// How light a picture is and how much it shows: what tells a lens that is covered. Shares of full scale, 0
/// to 1.
struct PictureLight {
  float mean = 0;
  float contrast = 0;  ///< From the level that 2 % of its pixels do not exceed to that of 98 %.
};

/// None of a sample of any other kind.
[[nodiscard]] inline std::optional<PictureLight> picture_light(const Sample& sample) {
  if (sample.kind != SampleKind::picture || sample.count < 6) return std::nullopt;
  return PictureLight{.mean = sample.values[0], .contrast = sample.values[5] - sample.values[4]};
}

}  // namespace mien::sensor
