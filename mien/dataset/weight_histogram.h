#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mien/face/profile.h"

namespace mien::dataset {

/// Between what one shape was: all but the extreme hundredths of it.
struct ShapeRange {
  float low = 0;   ///< 1st percentile, ...
  float high = 0;  ///< ... and 99th: weights, 0 to 1, to 0.001.
  bool operator==(const ShapeRange&) const = default;
};

/// How often each shape had which weight, over frames of any number of takes.
class WeightHistogram {
 public:
  /// Weights count as 0 to 1.
  void add(const face::BlendshapeWeights& weights);
  void add(const WeightHistogram& other);
  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  /// Zeros where there were no frames.
  [[nodiscard]] std::array<ShapeRange, face::kShapeCount> ranges() const;

 private:
  static constexpr std::size_t kSteps = 1000;
  std::uint64_t frames_ = 0;
  std::array<std::array<std::uint32_t, kSteps + 1>, face::kShapeCount> counts_{};
};

}  // namespace mien::dataset
