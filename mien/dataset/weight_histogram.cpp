#include "mien/dataset/weight_histogram.h"

#include <algorithm>
#include <cmath>

namespace mien::dataset {

void WeightHistogram::add(const face::BlendshapeWeights& weights) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const float held = std::clamp(weights[k], 0.0F, 1.0F);
    ++counts_[k][static_cast<std::size_t>(std::lround(held * kSteps))];
  }
  ++frames_;
}

void WeightHistogram::add(const WeightHistogram& other) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    for (std::size_t step = 0; step <= kSteps; ++step) counts_[k][step] += other.counts_[k][step];
  frames_ += other.frames_;
}

std::array<ShapeRange, face::kShapeCount> WeightHistogram::ranges() const {
  std::array<ShapeRange, face::kShapeCount> out{};
  if (frames_ == 0) return out;
  // The least weight that at least this share of the frames do not exceed.
  const auto percentile = [this](std::size_t shape, double share) {
    const double wanted = share * static_cast<double>(frames_);
    std::uint64_t below = 0;
    std::size_t step = 0;
    for (; step < kSteps; ++step) {
      below += counts_[shape][step];
      if (static_cast<double>(below) >= wanted) break;
    }
    return static_cast<float>(step) / kSteps;
  };
  for (std::size_t k = 0; k < face::kShapeCount; ++k) out[k] = {percentile(k, 0.01), percentile(k, 0.99)};
  return out;
}

}  // namespace mien::dataset
