#pragma once

#include <optional>
#include <span>

#include "mien/measure/metrics.h"

namespace mien::lab {

/// What mouth and jaw are worth that were shown.
struct MouthScore {
  /// Mean error of the face's vertices, mm, where mouth and jaw alone move it: of all other shapes the truth
  /// counts as shown.
  double mouth_mm = 0;
  std::optional<double> jaw;  ///< Correlation of jawOpen with the truth's; none where either stands still.
};

/// All stretches as one.
[[nodiscard]] MouthScore score_mouth(const measure::Meter& meter,
                                     std::span<const measure::Stretch> stretches);

}  // namespace mien::lab
