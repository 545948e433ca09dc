#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"
#include "mien/builtin_face/surface.h"

namespace mien::builtin_face {
namespace {

constexpr double kAbove = 3;      // Cloth over skin, mm.
constexpr double kThroat = -112;  // Height below which the neck is no chin any more, mm.
const Vec3 kChest(0, -228, -26);

/// Distance (mm, about) to neck, shoulders and chest as a shirt lies over them; negative inside.
double body_distance(const Vec3& p) {
  const Vec3 q(std::abs(p.x()), p.y(), p.z());
  double d = capsule(q, {30, -176, -40}, 34, {112, -196, -44}, 34);
  d = join(d, capsule(q, {112, -196, -44}, 34, {152, -236, -44}, 42), 24);
  d = join(d, ellipsoid(p, {0, -262, 0}, {150, 92, 72}), 40);
  d = join(d, ellipsoid(p, {0, -245, -52}, {146, 112, 60}), 40);
  // Of the head only the neck: rays from the chest pass before the chin.
  return join(d, std::max(head_distance(p) - kAbove, p.y() - kThroat), 10);
}

/// Where the ray from `origin` leaves the shirt. Azimuth 0 is forward, positive to the left.
Vec3 shirt_point(const Vec3& origin, double azimuth_rad, double elevation_rad) {
  const Vec3 direction(std::sin(azimuth_rad) * std::cos(elevation_rad), std::sin(elevation_rad),
                       std::cos(azimuth_rad) * std::cos(elevation_rad));
  return surface_along(origin, direction,
                       {.from = 240, .most = 80, .share = 0.7, .near = 0.05, .least = 0.05}, body_distance);
}

}  // namespace

void add_shirt(Sculpt& half) {
  constexpr int kColumns = 26, kRows = 13;
  std::vector<Ring> rings(kRows + 2);
  for (int c = 0; c <= kColumns; ++c) {
    const double azimuth = M_PI * c / kColumns;
    // The collar is low in front and high behind.
    const double collar_y = mix(-121, -153, std::pow(0.5 + 0.5 * std::cos(azimuth), 1.4));
    const auto add = [&](std::size_t ring, Vec3 p) {
      if (c == 0 || c == kColumns) p.x() = 0;
      rings[ring].push_back(half.add(vertex(p, Tissue::cloth)));
    };
    const Vec3 edge = shirt_point({0, collar_y, kChest.z()}, azimuth, 0);
    const Vec3 out(std::sin(azimuth), 0, std::cos(azimuth));
    const double elevation = std::atan2(edge.y() - kChest.y(), (edge - kChest).dot(out));
    add(0, edge - 2.2 * out - Vec3(0, 7, 0));
    add(1, edge + 0.6 * out + Vec3(0, 0.6, 0));
    for (int r = 1; r <= kRows; ++r) {
      const double s = static_cast<double>(r) / kRows;
      // A band about the neck, then the cloth.
      const Vec3 p = shirt_point(kChest, azimuth, mix(elevation, 0.0, std::pow(s, 1.25)));
      add(static_cast<std::size_t>(r) + 1, p + (r == 1 ? 1.6 : 0.6) * (p - kChest).normalized());
    }
  }
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) sew(half, Piece::shirt, rings[r + 1], rings[r], false);
}

}  // namespace mien::builtin_face
