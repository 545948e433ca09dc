#pragma once

#include <cstddef>
#include <optional>

#include "mien/core/sliding_median.h"

namespace mien::eyewear {

/// How many consecutive samples the published system takes the median of: light that flashes for less than
/// half of them (motion capture's lamps) leaves no trace.
inline constexpr std::size_t kMedianSamples = 10;

/// The median of every ten consecutive values, once each: a sensor of 230 readings a second gives 23. The
/// median of ten is the mean of the middle two. No allocation.
class BlockMedian {
 public:
  /// The median when `value` completes ten, which then begin anew.
  std::optional<float> add(float value);
  /// Forgets an unfinished ten, as after a gap.
  void reset() { median_.reset(); }

 private:
  SlidingMedian<kMedianSamples> median_;
};

}  // namespace mien::eyewear
