#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/blink.h"

namespace mien::performer {

/// Spontaneous blinks over [0, duration_s), in order, not overlapping. Intervals are log-normal with mean 60
/// / rate; a blink near a cue (pause of speech, gaze shift; `cues_s`, ascending) often moves to it
/// (log-normal: Naase et al. 2005, doi:10.1111/j.1444-0938.2005.tb05086.x). Seconds from the performance's
/// start.
[[nodiscard]] std::vector<face::Blink> draw_blinks(double duration_s, double rate_per_min,
                                                   std::span<const double> cues_s, Random random);

/// eyeBlink weights of `blinks` at 60 Hz: (left, right) a frame.
[[nodiscard]] std::vector<std::array<float, 2>> lid_tracks(std::span<const face::Blink> blinks,
                                                           std::size_t frame_count);

}  // namespace mien::performer
