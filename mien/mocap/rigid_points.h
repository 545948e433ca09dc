#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/rotation.h"

namespace mien::mocap {

/// Points that hold still against each other, or nearly: a body whose place can be told from where they are
/// seen.
struct RigidPoints {
  std::vector<Vec3> place_m;  ///< In the body's frame.
  std::vector<double>
      slack_m;  ///< How far each moves against the others, one sigma; above 0. Beside place_m.
};

/// The rigid motion that takes the points as they are seen to the body's own places: p_body = fit * p_seen.
/// Weighted least squares (Kabsch 1976, doi:10.1107/S0567739476001873), each point by 1 / slack^2. A point
/// that then is off by more than four times its slack and a millimetre is left out, the worst first, and the
/// rest fitted again. None where fewer than three points are left, or they stand in one line within 5 mm.
/// `seen` has one for each of the body's, kLostMarker where lost.
[[nodiscard]] std::optional<Eigen::Isometry3d> fit_rigid(const RigidPoints& body,
                                                         std::span<const Vec3f> seen);

/// A marker of a set that expressions hardly move.
struct ReferenceMarker {
  std::size_t marker = 0;  ///< Its place in the set.
  double slack_m = 0;      ///< One sigma of its motion on an expressive face.
};

/// The markers of a face that tell where the head is: those that all shapes of the face together move least,
/// eight of them (or all, where there are fewer), by rising slack. docs/method/markers.md says which of the
/// 37 these are.
[[nodiscard]] std::vector<ReferenceMarker> reference_markers(const builtin_face::PlacedMarkers& placed);

}  // namespace mien::mocap
