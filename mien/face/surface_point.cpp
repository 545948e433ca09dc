#include "mien/face/surface_point.h"

#include <algorithm>
#include <limits>

namespace mien::face {
namespace {

Vec3 neutral(const Face& face, std::uint32_t vertex) {
  return face.neutral_m[vertex].cast<double>();
}

/// The point of the triangle nearest to p. Source: Ericson 2005, "Real-Time Collision Detection", 5.1.5.
SurfacePoint nearest_on_triangle(const Face& face, const std::array<std::uint32_t, 3>& triangle,
                                 const Vec3& p) {
  const Vec3 a = neutral(face, triangle[0]);
  const Vec3 ab = neutral(face, triangle[1]) - a;
  const Vec3 ac = neutral(face, triangle[2]) - a;
  const Vec3 ap = p - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {triangle, {1, 0, 0}};
  const double d3 = d1 - ab.dot(ab);
  const double d4 = d2 - ab.dot(ac);
  if (d3 >= 0 && d4 <= d3) return {triangle, {0, 1, 0}};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {triangle, {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0}};
  const double d5 = d1 - ab.dot(ac);
  const double d6 = d2 - ac.dot(ac);
  if (d6 >= 0 && d5 <= d6) return {triangle, {0, 0, 1}};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {triangle, {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)}};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double u = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {triangle, {0, 1 - u, u}};
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return {triangle, {1, 0, 0}};  // A degenerate triangle: its corner will do.
  return {triangle, {va / sum, vb / sum, vc / sum}};
}

}  // namespace

Vec3 neutral_position(const Face& face, const SurfacePoint& p) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t c = 0; c < 3; ++c) sum += p.weight[c] * neutral(face, p.vertex[c]);
  return sum;
}

Vec3 displacement(const Shape& shape, const SurfacePoint& point) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    if (point.weight[c] == 0) continue;
    const auto found = std::ranges::lower_bound(shape.vertex, point.vertex[c]);
    if (found == shape.vertex.end() || *found != point.vertex[c]) continue;
    sum += point.weight[c] *
           shape.delta_m[static_cast<std::size_t>(found - shape.vertex.begin())].cast<double>();
  }
  return sum;
}

std::vector<std::uint32_t> skin_triangles(const Face& face) {
  std::vector<std::uint32_t> triangles;
  for (const Part& part : face.parts)
    if (part.material == Material::skin || part.material == Material::lips)
      for (std::uint32_t t = 0; t < part.triangle_count; ++t) triangles.push_back(part.first_triangle + t);
  if (triangles.empty())
    for (std::uint32_t t = 0; t < face.triangles.size(); ++t) triangles.push_back(t);
  return triangles;
}

SurfacePoint nearest_on_skin(const Face& face, std::span<const std::uint32_t> triangles, const Vec3& p) {
  SurfacePoint best;
  double best_square = std::numeric_limits<double>::infinity();
  for (const std::uint32_t t : triangles) {
    const SurfacePoint point = nearest_on_triangle(face, face.triangles[t], p);
    const double square = (neutral_position(face, point) - p).squaredNorm();
    if (square < best_square) {
      best_square = square;
      best = point;
    }
  }
  return best;
}

bool inside_polygon(std::span<const Eigen::Vector2f> polygon, const Eigen::Vector2f& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto& a = polygon[i];
    const auto& b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

Eigen::Affine3d align_landmarks(const Face& from, const Face& to) {
  Eigen::Matrix<double, 3, 68> a;
  Eigen::Matrix<double, 3, 68> b;
  for (std::size_t i = 0; i < 68; ++i) {
    a.col(static_cast<Eigen::Index>(i)) = neutral(from, from.landmarks[i]);
    b.col(static_cast<Eigen::Index>(i)) = neutral(to, to.landmarks[i]);
  }
  return Eigen::Affine3d(Eigen::umeyama(a, b, true));
}

}  // namespace mien::face
