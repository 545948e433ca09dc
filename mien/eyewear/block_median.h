#pragma once

#include <cstddef>
#include <optional>

#include "mien/core/sliding_median.h"

namespace mien::eyewear {

/// Length of the published system's median filter, in samples: flashes that hit fewer than half of them
/// (motion capture's strobes) leave no trace.
inline constexpr std::size_t kMedianSamples = 10;

/// Decimating median: one value for every ten consecutive ones (a sensor of 230 Hz gives 23 Hz), the mean of
/// the middle two. No allocation.
class BlockMedian {
 public:
  /// The median where `value` completes a block of ten; none otherwise.
  std::optional<float> add(float value);
  /// Drops an unfinished block, as after a gap.
  void reset() { median_.reset(); }

 private:
  SlidingMedian<kMedianSamples> median_;
};

}  // namespace mien::eyewear
