#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "mien/face/profile.h"

namespace mien::measure {

/// Errors of weights over frames, estimate less truth, both clipped to [0, 1]. Thread: one at a time.
class WeightErrors {
 public:
  void add(const face::BlendshapeWeights& estimate, const face::BlendshapeWeights& truth) {
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const double error = std::clamp(estimate[k], 0.0F, 1.0F) - std::clamp(truth[k], 0.0F, 1.0F);
      squares_ += error * error / face::kShapeCount;
      sums_[k] += error;
    }
    ++frames_;
  }

  [[nodiscard]] std::size_t frames() const { return frames_; }
  /// As Metrics::mse. At least one frame has been added.
  [[nodiscard]] double mse() const { return squares_ / static_cast<double>(frames_); }
  /// Mean error of a shape. At least one frame has been added.
  [[nodiscard]] double bias(std::size_t shape) const { return sums_[shape] / static_cast<double>(frames_); }

 private:
  std::size_t frames_ = 0;
  double squares_ = 0;
  std::array<double, face::kShapeCount> sums_{};
};

}  // namespace mien::measure
