#pragma once

#include <cstddef>
#include <cstdlib>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/mocap/marker_track.h"

/// What was accepted has a position for every marker and frame, in the order of time, and is taken back when
/// it was written (unless times a microsecond apart fell together). With `same_seen` also what was lost stays
/// so.
template <class Format, class Parse>
void expect_marker_round_trip(const mien::mocap::MarkerTrack& track, const Format& format, const Parse& parse,
                              bool same_seen) {
  using mien::mocap::is_seen;
  if (track.count() == 0 || track.frames() == 0 || track.position_m.size() != track.count() * track.frames())
    std::abort();
  for (std::size_t i = 1; i < track.frames(); ++i) {
    if (!(track.time_s[i] > track.time_s[i - 1])) std::abort();
    if (track.time_s[i] - track.time_s[i - 1] < 2e-6) return;
  }
  const auto again = parse(format(track), "again");
  if (!again || again->track.markers != track.markers || again->track.frames() != track.frames())
    std::abort();
  for (std::size_t i = 0; same_seen && i < track.position_m.size(); ++i)
    if (is_seen(track.position_m[i]) != is_seen(again->track.position_m[i])) std::abort();
}
