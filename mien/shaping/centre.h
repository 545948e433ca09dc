#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "mien/core/error.h"
#include "mien/face/profile.h"

namespace mien::shaping {

/// What a face at rest looks like to the tracker, and where ahead is: the whole state of re-centring. A
/// calibration version carries it.
struct Centre {
  /// A shape above this while the rest is measured is being performed, not at rest.
  static constexpr float kRestAtMost = 0.5f;

  /// Resting weight a shape, 0 to kRestAtMost; it is taken away, and the rest of the range stretched over it.
  std::array<float, face::kShapeCount> rest{};
  /// Heading of the performer's ahead in W, rad about +Y, -pi to pi; the head is turned back by it.
  double yaw_rad = 0;
  bool operator==(const Centre&) const = default;
};

/// JSON text that parse_centre takes back to an equal one: {"rest": {shape: weight}, "yaw_rad": number};
/// shapes without a rest are left out.
[[nodiscard]] std::string write_centre(const Centre& centre);
/// Errors: malformed (no JSON, unknown key or shape, a value of another type), out_of_range. `where` names
/// the source in messages.
[[nodiscard]] Result<Centre> parse_centre(std::string_view json, const std::string& where);

}  // namespace mien::shaping
