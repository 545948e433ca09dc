#include "mien/performer/blinks.h"

#include <algorithm>
#include <cmath>

#include "mien/core/time.h"

namespace mien::performer {

using face::Blink;

namespace {

constexpr double kSpread = 0.65;  // Of the logarithm of intervals: long and short ones, never a metronome.
constexpr double kLeastGap_s = 0.12;  // Between the end of one blink and the start of the next.
constexpr double kCueReach_s = 0.7;   // A cue this near draws a blink to itself,
constexpr double kCuePull = 0.6;      // this often.

/// The cue nearest to `time_s` within reach; `time_s` itself when there is none.
double nearest_cue(std::span<const double> cues_s, double time_s) {
  const auto after = std::ranges::lower_bound(cues_s, time_s);
  double best = time_s;
  double distance = kCueReach_s;
  if (after != cues_s.end() && *after - time_s < distance) {
    best = *after;
    distance = *after - time_s;
  }
  if (after != cues_s.begin() && time_s - *(after - 1) < distance) best = *(after - 1);
  return best;
}

}  // namespace

std::vector<Blink> draw_blinks(double duration_s, double rate_per_min, std::span<const double> cues_s,
                               Random random) {
  std::vector<Blink> blinks;
  if (rate_per_min <= 0) return blinks;
  const double mean_s = 60 / rate_per_min;
  const double centre = std::log(mean_s) - 0.5 * kSpread * kSpread;
  // The first interval is under way when the performance begins.
  const double started = random.uniform();  // Somewhere between two blinks.
  double next_s = started * std::exp(random.normal(centre, kSpread));
  double free_s = 0;
  while (next_s < duration_s) {
    double begin_s = next_s;
    if (random.chance(kCuePull)) begin_s = nearest_cue(cues_s, begin_s);
    begin_s = std::max(begin_s, free_s);
    if (begin_s >= duration_s) break;
    blinks.push_back(face::draw_blink(begin_s, random));
    free_s = blinks.back().end_s() + kLeastGap_s;
    // From the drawn time, not from the cue's: cues move blinks and leave the rate alone.
    next_s += std::exp(random.normal(centre, kSpread));
  }
  return blinks;
}

std::vector<std::array<float, 2>> lid_tracks(std::span<const Blink> blinks, std::size_t frame_count) {
  std::vector<std::array<float, 2>> lids(frame_count, {0.0F, 0.0F});
  for (const Blink& blink : blinks) {
    const double from = std::max(0.0, std::floor((blink.begin_s - 0.05) * kFrameRateHz));
    const double to = std::ceil((blink.end_s() + 0.05) * kFrameRateHz);
    for (auto i = static_cast<std::size_t>(from); i < frame_count && static_cast<double>(i) <= to; ++i)
      for (int side = 0; side < 2; ++side) {
        const auto now = static_cast<float>(blink.at(static_cast<double>(i) / kFrameRateHz, side));
        auto& lid = lids[i][static_cast<std::size_t>(side)];
        lid = std::max(lid, now);
      }
  }
  return lids;
}

}  // namespace mien::performer
