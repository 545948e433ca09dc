#pragma once

#include <algorithm>
#include <array>

#include "mien/face/output_frame.h"

namespace mien::shaping {

/// One shape's gain and range.
struct ShapeLimits {
  static constexpr float kGainAtMost = 4;
  float gain = 1;  ///< 0 to kGainAtMost. Raising exaggerates the shape and its noise; lowering damps both.
  float low = 0;   ///< Lower bound, 0 to `high`. Raising: the shape is never fully released.
  float high = 1;  ///< Upper bound, `low` to 1. Lowering: the shape never gets stronger.
  bool operator==(const ShapeLimits&) const = default;
};

/// w' = min(max(gain * w, low), high) for each shape. The default changes no bit.
struct Limits {
  std::array<ShapeLimits, face::kShapeCount> shapes{};

  /// No allocation. Thread-safe.
  void apply(face::OutputFrame& frame) const {
    for (std::size_t i = 0; i < face::kShapeCount; ++i)
      frame.weights[i] = std::min(std::max(shapes[i].gain * frame.weights[i], shapes[i].low), shapes[i].high);
  }
  bool operator==(const Limits&) const = default;
};

}  // namespace mien::shaping
