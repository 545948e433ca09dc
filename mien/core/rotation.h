#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <span>

namespace mien {

using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Mat3 = Eigen::Matrix3d;
/// Unit quaternions. A rotation is named q_dst_src and p_dst = q_dst_src * p_src (docs/reference/frames.md).
using Quat = Eigen::Quaterniond;

/// The rotation about `vector_rad` by its length in radians.
[[nodiscard]] Quat exp_rotation(const Vec3& vector_rad);

/// The rotation vector of q, of length in [0, pi]. The inverse of exp_rotation up to full turns.
[[nodiscard]] Vec3 log_rotation(const Quat& q);

/// The same rotation with w >= 0 and unit length: how quaternions leave this program.
[[nodiscard]] Quat canonical(const Quat& q);

/// As features and packets carry it: w, x, y, z.
[[nodiscard]] std::array<float, 4> wxyz_of(const Quat& q);
[[nodiscard]] Quat quat_of(const std::array<float, 4>& wxyz);

/// The angle between two orientations, in [0, pi].
[[nodiscard]] double angle_between(const Quat& a, const Quat& b);

/// The part of q that turns about the unit vector `axis`; q = swing * twist.
[[nodiscard]] Quat twist_about(const Quat& q, const Vec3& axis);

/// How long the outer two of three neighbouring intervals are, the middle one being 1; above 0.
struct KnotSpacing {
  double before = 1;  ///< From a to b.
  double after = 1;   ///< From c to d.
};

/// Between `b` (u = 0) and `c` (u = 1) along a cubic through four orientations (Catmull-Rom's where they are
/// evenly timed; else with the slopes of parabolas through three, and across a gap, ten times its neighbour,
/// with none steeper than three times the way from b to c: a quick movement before it must not swing through
/// all of it), taken in the tangent space at b: angular velocity has no steps at the samples, as slerp's has,
/// but at a gap's ends. Neighbours within half a turn.
[[nodiscard]] Quat interpolate_rotation(const Quat& a, const Quat& b, const Quat& c, const Quat& d, double u,
                                        const KnotSpacing& spacing = {});
/// The same for points.
[[nodiscard]] Vec3 interpolate_point(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double u,
                                     const KnotSpacing& spacing = {});

/// The rotation R that minimises sum |R (from_i - mean from) - (to_i - mean to)|^2 (Kabsch), never a mirror.
/// Shape: both of equal size, at least 3 points that are not all on one line.
[[nodiscard]] Quat fit_rotation(std::span<const Vec3> from, std::span<const Vec3> to);

/// The same from the 3 x 3 cross-covariance sum (from_i - mean)(to_i - mean)^T, for callers who sum it
/// themselves.
[[nodiscard]] Quat fit_rotation(const Mat3& covariance_from_to);

}  // namespace mien
