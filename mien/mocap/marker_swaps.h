#pragma once

#include <cstddef>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/mocap/marker_track.h"

namespace mien::mocap {

/// A stretch of frames with the labels of two markers swapped.
struct MarkerSwap {
  std::size_t a = 0;
  std::size_t b = 0;
  std::size_t begin = 0;  ///< Frames, ...
  std::size_t end = 0;    ///< ... one past the last.
  /// True: the labels were corrected. False: ambiguous, and both markers are lost in these frames.
  bool mended = true;
};

/// A stretch of frames in which a marker was displaced: it jumped away and came back.
struct MarkerStray {
  std::size_t marker = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Corrects swapped labels of neighbouring markers in `track` (head motion removed), and returns where.
/// Neighbours are pairs whose median places are within 30 mm, and each marker's nearest. A pair crosses
/// between two frames where each is nearer to the other's last position than to its own, by less than half
/// their distance. Which stretches between crossings are swapped is the maximum likelihood sequence given the
/// median places, over the whole recording (Viterbi 1967, doi:10.1109/TIT.1967.1054010); a stretch that fits
/// badly either way is lost. Cyclic swaps of three are not found. A pure function of the track. Cost: linear
/// in frames and pairs.
[[nodiscard]] std::vector<MarkerSwap> mend_swaps(MarkerTrack& track);

/// Finds markers that jump away, faster than skin can move, and return within three seconds to about where
/// they were, and marks them as lost in between. For recordings of 60 frames a second or more; slower ones
/// have steps as large as jumps. After mend_swaps().
[[nodiscard]] std::vector<MarkerStray> lose_strays(MarkerTrack& track);

/// Median position of each marker over the frames that have it; kLostMarker where none does.
[[nodiscard]] std::vector<Vec3f> usual_places(const MarkerTrack& track);

}  // namespace mien::mocap
