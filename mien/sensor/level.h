#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "mien/sensor/sample.h"

namespace mien::sensor {

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

}  // namespace mien::sensor
