#pragma once

#include <array>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/face/profile.h"

namespace mien::shaping {

/// State of re-centring: the tracker's output for the resting face, the heading that counts as ahead, and the
/// place of the head that counts as 0.
/// Stored in calibration versions.
struct Centre {
  /// A shape whose rest would be above this is being performed, not at rest.
  static constexpr float kRestAtMost = 0.5f;

  /// Resting weight of each shape, 0 to kRestAtMost: w' = max(0, (w - rest) / (1 - rest)).
  std::array<float, face::kShapeCount> rest{};
  /// Heading of the performer's ahead in frame W, rad about +Y, -pi to pi; subtracted from the head's.
  double yaw_rad = 0;
  /// Coordinates of `position_m`, each way.
  static constexpr double kPositionAtMost_m = 10;
  /// Where the head counts as being at 0, as its tracker tells it, frame W, m; subtracted from the head's
  /// where that is known, before it is turned.
  Vec3 position_m = Vec3::Zero();
  bool operator==(const Centre&) const = default;
};

/// JSON, from which parse_centre restores an equal value: {"rest": {shape: weight}, "yaw_rad": number,
/// "position_m": [x, y, z]}; shapes without a rest and a position of 0 are left out.
[[nodiscard]] std::string write_centre(const Centre& centre);
/// Errors: malformed (no JSON, unknown key or shape, a value of another type), out_of_range. `where` names
/// the source in messages.
[[nodiscard]] Result<Centre> parse_centre(std::string_view json, const std::string& where);

}  // namespace mien::shaping
