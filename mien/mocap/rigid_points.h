#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mien/builtin_face/markers.h"
#include "mien/core/rotation.h"

namespace mien::mocap {

/// A nearly rigid body, by points on it, from which a pose can be fitted.
struct RigidPoints {
  std::vector<Vec3> place_m;    ///< Positions in the body's frame, m.
  std::vector<double> slack_m;  ///< Standard deviation of each point's motion on the body, m, > 0.
};

/// The rigid transform from seen points to the body's frame: p_body = fit * p_seen. Weighted least squares
/// (Kabsch 1976, doi:10.1107/S0567739476001873), weights 1 / slack^2. Points with a residual above four times
/// their slack plus a millimetre are removed, the worst first, and the rest fitted again. None where fewer
/// than three points remain, or they are collinear within 5 mm. `seen`: one for each of the body's points,
/// kLostMarker where lost.
[[nodiscard]] std::optional<Eigen::Isometry3d> fit_rigid(const RigidPoints& body,
                                                         std::span<const Vec3f> seen);

/// A marker of a set for head pose: expressions hardly move it.
struct ReferenceMarker {
  std::size_t marker = 0;  ///< Its index in the set.
  double slack_m = 0;      ///< Standard deviation of its motion by expressions, m.
};

/// The reference markers of a face: the eight (or all, if fewer) that its shapes move least, by rising slack.
/// docs/method/markers.md lists them.
[[nodiscard]] std::vector<ReferenceMarker> reference_markers(const builtin_face::PlacedMarkers& placed);

}  // namespace mien::mocap
