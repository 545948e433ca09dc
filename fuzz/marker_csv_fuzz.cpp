#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "mien/eyewear/marker_csv.h"

// Ours and Motive's. What was accepted has a position for every marker and frame, and is taken back when it
// was written (unless times a microsecond apart fell together).
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::eyewear;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  (void)is_marker_csv(text);
  const auto read = is_motive_csv(text) ? parse_motive_csv(text, "fuzz") : parse_marker_csv(text, "fuzz");
  if (!read) return 0;
  const MarkerTrack& track = read->track;
  if (track.count() == 0 || track.frames() == 0 || track.position_m.size() != track.count() * track.frames())
    std::abort();
  for (std::size_t i = 1; i < track.frames(); ++i) {
    if (!(track.time_s[i] > track.time_s[i - 1])) std::abort();
    if (track.time_s[i] - track.time_s[i - 1] < 2e-6) return 0;
  }
  const auto again = parse_marker_csv(format_marker_csv(track), "again");
  if (!again || again->track.markers != track.markers || again->track.frames() != track.frames())
    std::abort();
  for (std::size_t i = 0; i < track.position_m.size(); ++i)
    if (is_seen(track.position_m[i]) != is_seen(again->track.position_m[i])) std::abort();
  return 0;
}
