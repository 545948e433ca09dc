#pragma once

#include "mien/core/minimum_jerk.h"
#include "mien/core/random.h"

namespace mien::face {

/// One blink of both lids. Times in seconds, from wherever its user counts.
struct Blink {
  double begin_s = 0;
  double closing_s = 0.09;
  double hold_s = 0.02;
  double opening_s = 0.18;
  double peak = 1;         ///< Largest eyeBlink weight: 1 closes; less is a partial blink.
  double right_lag_s = 0;  ///< Delay of the right lid; may be negative.
  [[nodiscard]] double end_s() const { return begin_s + closing_s + hold_s + opening_s; }
  /// eyeBlink weight, 0 to peak, with minimum-jerk slopes. `side`: 0 left, 1 right.
  [[nodiscard]] double at(double time_s, int side) const {
    return peak * Envelope{begin_s + (side == 1 ? right_lag_s : 0), closing_s, hold_s, opening_s}.at(time_s);
  }
};

/// A blink as people's are: closing 80 to 100 ms, opening 150 to 200 ms, one in five partial (peak 0.3 to
/// 0.75), the lids some milliseconds apart. Source of the times: Evinger et al. 1991, "Eyelid movements",
/// IOVS 32(2).
[[nodiscard]] Blink draw_blink(double begin_s, Random& random);

}  // namespace mien::face
