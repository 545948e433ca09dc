#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/random.h"

namespace mien::performer {

/// One blink of both lids. Times in seconds from the performance's start.
struct Blink {
  double begin_s = 0;
  double closing_s = 0.09;
  double hold_s = 0.02;
  double opening_s = 0.18;
  double peak = 1;         ///< Largest eyeBlink weight: 1 closes; less is a partial blink.
  double right_lag_s = 0;  ///< Delay of the right lid; may be negative.
  [[nodiscard]] double end_s() const { return begin_s + closing_s + hold_s + opening_s; }
  /// eyeBlink weight, 0 to peak. `side`: 0 left, 1 right.
  [[nodiscard]] double at(double time_s, int side) const;
};

/// Spontaneous blinks over [0, duration_s), in order, not overlapping. Intervals are log-normal with mean 60
/// / rate; a blink near a cue (pause of speech, gaze shift; `cues_s`, ascending) often moves to it. Closing
/// 80 to 100 ms, opening 150 to 200 ms, one in five partial. Sources: times, Evinger et al. 1991, "Eyelid
/// movements", IOVS 32(2); log-normal intervals, Naase et al. 2005, doi:10.1111/j.1444-0938.2005.tb05086.x.
[[nodiscard]] std::vector<Blink> draw_blinks(double duration_s, double rate_per_min,
                                             std::span<const double> cues_s, Random random);

/// eyeBlink weights of `blinks` at 60 Hz: (left, right) a frame.
[[nodiscard]] std::vector<std::array<float, 2>> lid_tracks(std::span<const Blink> blinks,
                                                           std::size_t frame_count);

}  // namespace mien::performer
