#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::face {

/// A point that is fixed to the mesh: a triangle's corners and their barycentric weights (at least 0, sum 1).
/// A vertex is one with weights (1, 0, 0).
struct SurfacePoint {
  std::array<std::uint32_t, 3> vertex{};
  std::array<double, 3> weight{};
};

/// Where the point is on the neutral face B0, frame H, metres.
[[nodiscard]] Vec3 neutral_position(const Face& face, const SurfacePoint& point);

/// How far the shape moves the point at weight 1, metres; zero where it does not reach.
[[nodiscard]] Vec3 displacement(const Shape& shape, const SurfacePoint& point);

/// Indices of the triangles of skin and lips: what something can be glued to, or be seen of the outside. All
/// triangles where the face's parts do not tell.
[[nodiscard]] std::vector<std::uint32_t> skin_triangles(const Face& face);

/// The point of these triangles that lies nearest to p on the neutral face. `triangles` are indices into
/// face.triangles, at least one. Cost: each triangle is looked at.
[[nodiscard]] SurfacePoint nearest_on_skin(const Face& face, std::span<const std::uint32_t> triangles,
                                           const Vec3& p);

/// Whether p lies inside a polygon (even-odd rule).
[[nodiscard]] bool inside_polygon(std::span<const Eigen::Vector2f> polygon, const Eigen::Vector2f& p);

/// Similarity transform that lays one face's 68 landmarks onto another's (Umeyama 1991,
/// doi:10.1109/34.88573). Both have landmarks.
[[nodiscard]] Eigen::Affine3d align_landmarks(const Face& from, const Face& to);

}  // namespace mien::face
