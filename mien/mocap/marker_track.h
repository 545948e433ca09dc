#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/error.h"
#include "mien/core/rotation.h"

namespace mien::mocap {

/// Markers of one recording at most; what a parser believes.
inline constexpr std::size_t kMaxTrackMarkers = 512;
/// Farther from the cameras' origin than this is a mistake of units.
inline constexpr double kMaxTrackPositionM = 100;
/// A recorder's clock may count from anywhere; beyond this its times would lose microseconds.
inline constexpr double kMaxTrackTimeS = 1e9;
/// Where a marker is that was not seen.
inline const Vec3f kLostMarker = Vec3f::Constant(std::numeric_limits<float>::quiet_NaN());

/// A recording of 3-D markers, as cameras see them: any right-handed frame, metres.
struct MarkerTrack {
  std::string name;                  ///< The file's stem, or where they were heard.
  std::vector<std::string> markers;  ///< Their names, no two alike.
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

/// What a recording calls the markers of a set.
struct MarkerNames {
  /// Theirs to ours; to an empty name: left out.
  std::vector<std::pair<std::string, std::string>> renamed;
  /// Theirs: markers of a body that is fixed to the head (a band, a helmet) and of no skin.
  std::vector<std::string> head;
};

/// A recording in the order of a marker set.
struct MatchedTrack {
  MarkerTrack face;  ///< The set's markers; those that the recording lacks are lost throughout.
  MarkerTrack head;  ///< Those of MarkerNames::head, in its order; none without it.
  std::vector<std::string> missing;  ///< Of the set.
  std::size_t unlabelled = 0;        ///< Of the recording, left out: "Unlabeled 1234" and "*12".
};

/// Puts a recording's markers in the set's order. A name fits as MarkerNames say, else letter by letter, else
/// without case and without what stands before a colon ("Face:Brow_Inner_R"). Errors: mismatch (markers that
/// are none of the set's, all listed; two that are one; none at all), not_found (a name of MarkerNames that
/// the recording or the set lacks).
[[nodiscard]] Result<MatchedTrack> match_markers(const MarkerTrack& track, const builtin_face::MarkerSet& set,
                                                 const MarkerNames& names = {});

}  // namespace mien::mocap
