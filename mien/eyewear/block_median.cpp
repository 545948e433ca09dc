#include "mien/eyewear/block_median.h"

namespace mien::eyewear {

std::optional<float> BlockMedian::add(float value) {
  const double median = median_.add(static_cast<double>(value));
  if (median_.count() < kMedianSamples) return std::nullopt;
  median_.reset();
  return static_cast<float>(median);
}

}  // namespace mien::eyewear
