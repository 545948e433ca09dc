#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/headset/gaze_map.h"
#include "mien/headset/neutral_face.h"

namespace mien::headset {

/// What is known of one wearer: the face at rest, and where it was learnt what to make of the eyes'
/// directions that are found beside it. It corrects in that order: the map reads directions that the
/// neutral corrected.
struct WearerCalibration {
  NeutralFace neutral;
  std::optional<GazeMap> gaze;
  bool operator==(const WearerCalibration&) const = default;
};

/// JSON: the neutral's, and "gaze" where it is known. parse_wearer_calibration takes it back. Errors:
/// parse_neutral_face's and parse_gaze_map's.
[[nodiscard]] std::string write_wearer_calibration(const WearerCalibration& calibration);
[[nodiscard]] Result<WearerCalibration> parse_wearer_calibration(std::string_view json,
                                                                 const std::string& where);

}  // namespace mien::headset
