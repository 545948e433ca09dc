#pragma once

#include <array>

#include "mien/face/output_frame.h"

namespace mien::shaping {

/// One shape's gain and range.
struct ShapeLimits {
  static constexpr float kGainAtMost = 4;
  float gain = 1;  ///< 0 to kGainAtMost. Raising exaggerates the shape, and its noise.
  float low = 0;   ///< 0 to 1, at most `high`: never less than this is shown.
  float high = 1;  ///< 0 to 1: never more.
  bool operator==(const ShapeLimits&) const = default;
};

/// w' = min(max(gain * w, low), high), a shape. The default changes no bit.
struct Limits {
  std::array<ShapeLimits, face::kShapeCount> shapes{};

  /// No allocation. Thread-safe.
  void apply(face::OutputFrame& frame) const;
  bool operator==(const Limits&) const = default;
};

}  // namespace mien::shaping
