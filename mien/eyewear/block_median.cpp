#include "mien/eyewear/block_median.h"

#include <algorithm>

namespace mien::eyewear {

std::optional<float> BlockMedian::add(float value) {
  values_[count_++] = value;
  if (count_ < kMedianSamples) return std::nullopt;
  count_ = 0;
  std::ranges::sort(values_);
  return 0.5F * (values_[kMedianSamples / 2 - 1] + values_[kMedianSamples / 2]);
}

}  // namespace mien::eyewear
