#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/rotation.h"

namespace mien::mocap {

/// Most markers of one recording; limit of the parsers.
inline constexpr std::size_t kMaxTrackMarkers = 512;
/// Largest coordinate from the cameras' origin, m; beyond it the unit is wrong.
inline constexpr double kMaxTrackPositionM = 100;
/// Largest time of a recorder's clock, s, which may start anywhere; beyond it doubles lose microseconds.
inline constexpr double kMaxTrackTimeS = 1e9;
/// Position of a lost marker.
inline const Vec3f kLostMarker = Vec3f::Constant(std::numeric_limits<float>::quiet_NaN());

/// A recording of 3-D markers: any right-handed frame, metres.
struct MarkerTrack {
  std::string name;                  ///< The file's stem, or its source.
  std::vector<std::string> markers;  ///< Their names, unique.
  std::vector<double> time_s;        ///< Of each frame, rising, by the recorder's clock.
  std::vector<Vec3f> position_m;     ///< Frame by frame, the markers in their order; kLostMarker where lost.

  [[nodiscard]] std::size_t count() const { return markers.size(); }
  [[nodiscard]] std::size_t frames() const { return time_s.size(); }
  [[nodiscard]] std::span<const Vec3f> frame(std::size_t i) const {
    return std::span(position_m).subspan(i * count(), count());
  }
  [[nodiscard]] std::span<Vec3f> frame(std::size_t i) {
    return std::span(position_m).subspan(i * count(), count());
  }
  [[nodiscard]] double duration_s() const { return time_s.empty() ? 0 : time_s.back() - time_s.front(); }
};

/// Whether a marker was seen.
[[nodiscard]] inline bool is_seen(const Vec3f& position_m) {
  return position_m.allFinite();
}

/// Mapping of a recording's marker names to those of a set.
struct MarkerNames {
  /// (recording's, set's); an empty second: left out.
  std::vector<std::pair<std::string, std::string>> renamed;
  /// Recording's names of markers on a body fixed to the head (a band, a helmet), not on skin.
  std::vector<std::string> head;
};

/// A recording in the order of a marker set.
struct MatchedTrack {
  MarkerTrack face;  ///< In the set's order; markers that the recording lacks are lost throughout.
  MarkerTrack head;  ///< Those of MarkerNames::head, in its order; none without it.
  std::vector<std::string> missing;  ///< Markers of the set that the recording lacks.
  std::size_t unlabelled = 0;        ///< Markers of the recording left out: "Unlabeled 1234", "*12".
};

/// Puts a recording's markers in the set's order. Names match by MarkerNames, else exactly, else without case
/// and without a prefix up to a colon ("Face:Brow_Inner_R"). Errors: mismatch (markers that are none of the
/// set's, all listed; two that are one; none at all), not_found (a name of MarkerNames that the recording or
/// the set lacks).
[[nodiscard]] Result<MatchedTrack> match_markers(const MarkerTrack& track, const builtin_face::MarkerSet& set,
                                                 const MarkerNames& names = {});

}  // namespace mien::mocap
