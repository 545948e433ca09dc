#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lab/trackers/tracker_curves.h"
#include "mien/core/error.h"

namespace mien::lab {

/// One face in one frame, as OpenSeeFace's facetracker.py sends it: little-endian, packed.
inline constexpr std::size_t kOpenSeeFaceBlockBytes = 1785;

/// OpenSeeFace's features, in the order of the block and of the log's last columns. Each is 0 at the person's
/// own median, and -1 and 1 at the least and the most that was seen of them.
enum class OpenSeeFeature : std::uint8_t {
  eye_l,
  eye_r,
  eyebrow_steepness_l,
  eyebrow_updown_l,
  eyebrow_quirk_l,
  eyebrow_steepness_r,
  eyebrow_updown_r,
  eyebrow_quirk_r,
  mouth_corner_updown_l,
  mouth_corner_inout_l,
  mouth_corner_updown_r,
  mouth_corner_inout_r,
  mouth_open,
  mouth_wide
};
inline constexpr std::size_t kOpenSeeFeatureCount = 14;
inline constexpr std::array<std::string_view, kOpenSeeFeatureCount> kOpenSeeFeatureNames = {
    "eye_l",
    "eye_r",
    "eyebrow_steepness_l",
    "eyebrow_updown_l",
    "eyebrow_quirk_l",
    "eyebrow_steepness_r",
    "eyebrow_updown_r",
    "eyebrow_quirk_r",
    "mouth_corner_updown_l",
    "mouth_corner_inout_l",
    "mouth_corner_updown_r",
    "mouth_corner_inout_r",
    "mouth_open",
    "mouth_wide"};

/// What OpenSeeFace says of the face, apart from its points.
struct OpenSeeFace {
  float right_open = 1;  ///< How open the performer's right eye is, 0 to 1.
  float left_open = 1;
  std::array<float, kOpenSeeFeatureCount> features{};

  [[nodiscard]] float operator[](OpenSeeFeature feature) const {
    return features[static_cast<std::size_t>(feature)];
  }
  float& operator[](OpenSeeFeature feature) { return features[static_cast<std::size_t>(feature)]; }
};

/// The sixteen shapes that the features tell; of a log without features the two lids alone.
[[nodiscard]] const ToldShapes& openseeface_told();
[[nodiscard]] const ToldShapes& openseeface_lids();

/// The shapes of the features, each held to 0 to 1 (docs/reference/tracker_curves.md):
///
/// - eyeBlink: 1 - how open the eye is;
/// - browInnerUp and browOuterUp: eyebrow_updown where positive; browDown: where negative;
/// - jawOpen: mouth_open where positive;
/// - mouthSmile: mouth_corner_updown where *negative* (it is the upper lip less the corner: a corner that
///   rises makes it less), mouthFrown: where positive;
/// - mouthStretch, both sides: mouth_wide where positive; mouthPucker: where negative.
///
/// The mapping is ours: OpenSeeFace measures distances between points, and calls none of them a blendshape.
[[nodiscard]] face::BlendshapeWeights weights_of(const OpenSeeFace& face);

/// A recording of its packets: blocks one after another, several faces of a frame too, of which the lowest id
/// in the recording counts. Times are seconds since 1970; a block whose 3-D fit failed (success 0) is a gap,
/// and where no face is found nothing is sent. Errors: truncated (no whole block), malformed (a success that
/// is neither 0 nor 1, times that do not rise), out_of_range (a number that is not finite, an eye or feature
/// beyond 100, too many rows). A last block that is cut short is left out, with a warning.
[[nodiscard]] Result<TrackerCurves> parse_openseeface_blocks(std::span<const std::byte> bytes,
                                                             const std::string& name);

/// What facetracker.py writes with --log-data. Its header names 66 points, its rows have 68 in the picture
/// and 70 in space, so a row is 18 cells longer than the header; where the header ends with the fourteen
/// features they are a row's last cells. Older versions wrote none: then the lids alone are told. Errors:
/// truncated (no row), malformed (a header without Time, FaceID, RightOpen, LeftOpen, Success3D among its
/// first columns, a row of another length, times that do not rise), out_of_range (as above). A malformed last
/// row without a line end is left out, with a warning.
[[nodiscard]] Result<TrackerCurves> parse_openseeface_csv(std::string_view text, const std::string& name);

/// One block with these values, all else 0: for tests and for who sends as OpenSeeFace does.
[[nodiscard]] std::vector<std::byte> openseeface_block(double time_s, std::int32_t id, bool success,
                                                       const OpenSeeFace& face);

}  // namespace mien::lab
