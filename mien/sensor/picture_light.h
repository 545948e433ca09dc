#pragma once

#include <optional>

#include "mien/sensor/sample.h"

namespace mien::sensor {

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
