#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/mocap/c3d.h"

// What was accepted is no larger than its file, and all of it is seen within reach, or lost.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::mocap;
  const auto read = parse_c3d(std::as_bytes(std::span(data, size)), "fuzz");
  if (!read) return 0;
  const MarkerTrack& track = read->track;
  if (track.count() == 0 || track.frames() == 0 || track.position_m.size() != track.count() * track.frames())
    std::abort();
  if (8 * track.position_m.size() > size) std::abort();
  for (const auto& position : track.position_m)
    if (is_seen(position) &&
        !(static_cast<double>(position.cwiseAbs().maxCoeff()) <= 1.01 * kMaxTrackPositionM))
      std::abort();
  return 0;
}
