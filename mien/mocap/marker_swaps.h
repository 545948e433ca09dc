#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/mocap/marker_track.h"

namespace mien::mocap {

/// A stretch of frames in which two markers had each other's names.
struct MarkerSwap {
  std::size_t a = 0;
  std::size_t b = 0;
  std::size_t begin = 0;  ///< Frames, ...
  std::size_t end = 0;    ///< ... one past the last.
  /// True: the names were given back. False: which is which could not be told, and both are lost in these
  /// frames.
  bool mended = true;
};

/// A stretch of frames in which a marker was found where it is not: it jumped away and came back.
struct MarkerStray {
  std::size_t marker = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Finds markers that changed names with a neighbour, mends them in `track`, and tells where. The head's
/// motion has been taken out. Two neighbours (those whose usual places are within 30 mm, and each marker's
/// nearest) are crossed from one frame to the next where each is found nearer to where the other was than to
/// where it was itself, by less than half their distance. Which of the stretches between two crossings is the
/// swapped one is told by which fits the two markers' usual places, over the whole recording (Viterbi 1967,
/// doi:10.1109/TIT.1967.1054010); a stretch that fits them badly either way is not mended. Three that change
/// in a ring are not found. A pure function of the track. Cost: linear in frames and pairs.
[[nodiscard]] std::vector<MarkerSwap> mend_swaps(MarkerTrack& track);

/// Finds markers that jump away, faster than any skin, and back within three seconds to about where they
/// were, and makes them lost there. From 60 frames a second on; slower recordings' steps are as large as
/// jumps. After mend_swaps().
[[nodiscard]] std::vector<MarkerStray> lose_strays(MarkerTrack& track);

/// Where each marker usually is: the median over the frames that have it, kLostMarker where none does.
[[nodiscard]] std::vector<Vec3f> usual_places(const MarkerTrack& track);

}  // namespace mien::mocap
