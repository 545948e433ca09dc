#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"

namespace mien::builtin_face {
namespace {

/// The dental arch in the horizontal plane, by the way along it from the midline (mm): place, and direction
/// outward.
struct ArchPoint {
  Vec3 p, out;
};
ArchPoint arch_point(const DentalArch& arch, double way) {
  const auto& [half_width, front_z, depth, y] = arch;
  // A half ellipse walked in small steps; the arch is short and this is done once.
  double phi = 0, walked = 0;
  constexpr double kStep = 0.002;
  while (walked < way && phi < 0.5 * M_PI + 0.3) {
    walked += kStep * std::hypot(half_width * std::cos(phi), depth * std::sin(phi));
    phi += kStep;
  }
  const Vec3 p(half_width * std::sin(phi), y, front_z - depth + depth * std::cos(phi));
  const Vec3 out = Vec3(std::sin(phi) / half_width, 0, std::cos(phi) / depth).normalized();
  return {p, out};
}

void add_teeth(Sculpt& half, bool upper) {
  const Tissue tissue = upper ? Tissue::teeth_upper : Tissue::teeth_lower;
  const Piece piece = upper ? Piece::teeth_upper : Piece::teeth_lower;
  const double grow = upper ? -1 : 1;  // from the gum to the biting edge
  const double width_upper[] = {8.6, 6.6, 7.6, 7.0, 6.8, 10.0};
  const double width_lower[] = {5.6, 6.0, 6.9, 7.0, 7.0, 10.5};
  const double height_upper[] = {10.0, 9.0, 9.8, 8.4, 7.8, 7.2};
  const double height_lower[] = {8.4, 8.4, 8.6, 6.8, 5.6, 4.8};
  const DentalArch& arch = upper ? kUpperArch : kLowerArch;
  double way = 0;
  constexpr int kAround = 8;
  for (int t = 0; t < 6; ++t) {
    const double width = upper ? width_upper[t] : width_lower[t];
    const double height = upper ? height_upper[t] : height_lower[t];
    const ArchPoint at = arch_point(arch, way + 0.5 * width);
    way += width;
    const Vec3 along = Vec3::UnitY().cross(at.out);
    const double thick = t < 3 ? 6.0 : 8.5;
    Ring ring;
    // Level (share of the height), half width and half thickness as shares.
    const double levels[][3] = {{-0.15, 0.42, 0.40},
                                {0.3, 0.485, 0.5},
                                {0.72, 0.49, t < 3 ? 0.36 : 0.5},
                                {0.95, 0.45, t < 3 ? 0.2 : 0.42},
                                {1.0, 0.36, t < 3 ? 0.1 : 0.3}};
    for (const auto& level : levels) {
      Ring next;
      for (int i = 0; i < kAround; ++i) {
        const double phi = 2 * M_PI * i / kAround;
        const double c = std::cos(phi), s = std::sin(phi);
        const double square = std::pow(std::pow(std::abs(c), 3.0) + std::pow(std::abs(s), 3.0), -1.0 / 3.0);
        const Vec3 p =
            at.p + along * (c * square * width * level[1]) +
            at.out * (s * square * thick * level[2] - 0.5 * thick + (t < 3 ? 0.6 * level[0] : 0.0)) +
            Vec3(0, grow * height * level[0], 0);
        next.push_back(half.add(vertex(p, tissue, upper ? 1 : -1)));
      }
      if (!ring.empty()) upper ? sew(half, piece, ring, next, true) : sew(half, piece, next, ring, true);
      ring = std::move(next);
    }
    Vec3 middle = Vec3::Zero();
    for (const std::uint32_t i : ring) middle += half.vertices[i].p / kAround;
    const std::uint32_t edge = half.add(vertex(middle, tissue, upper ? 1 : -1));
    for (int i = 0; i < kAround; ++i) {
      const std::uint32_t a = ring[i], b = ring[(i + 1) % kAround];
      upper ? half.triangle(piece, a, b, edge) : half.triangle(piece, b, a, edge);
    }
  }
}

void add_gums(Sculpt& half, bool upper) {
  const Tissue tissue = upper ? Tissue::gums_upper : Tissue::gums_lower;
  const Piece piece = upper ? Piece::gums_upper : Piece::gums_lower;
  const DentalArch& arch = upper ? kUpperArch : kLowerArch;
  const double grow = upper ? 1 : -1;  // away from the biting edge
  // Outward and upward over the cross-section, front edge of the teeth to the palate.
  const double section[][2] = {{0.0, -1.2}, {1.0, 0.6}, {1.2, 4.0}, {-2.0, 8.0}, {-8.0, 6.5}, {-9.0, -0.5}};
  Ring ring;
  constexpr int kSteps = 14;
  for (int k = 0; k <= kSteps; ++k) {
    const ArchPoint at = arch_point(arch, 46.0 * k / kSteps);
    Ring next;
    for (const auto& s : section) {
      Vec3 p = at.p + at.out * s[0] + Vec3(0, grow * s[1], 0);
      if (k == 0) p.x() = 0;
      next.push_back(half.add(vertex(p, tissue, upper ? 1 : -1)));
    }
    if (!ring.empty()) upper ? sew(half, piece, next, ring, false) : sew(half, piece, ring, next, false);
    ring = std::move(next);
  }
}

void add_tongue(Sculpt& half) {
  // Half rings across, from the root to the tip; top first, round the left side, to the underside.
  constexpr int kAlong = 11, kAcross = 8;
  Ring ring;
  for (int k = 0; k <= kAlong; ++k) {
    const double s = static_cast<double>(k) / kAlong;
    const double z = mix(46, 95.5, s);
    const double width = 15.5 * std::pow(1 - std::pow(s, 2.2), 0.5);  // between the teeth
    const double thick = mix(9.0, 2.4, s) * std::pow(1 - std::pow(s, 6), 0.5);
    const double middle_y = mix(-47.5, -40.5, s);
    Ring next;
    for (int i = 0; i <= kAcross; ++i) {
      const double phi = 0.5 * M_PI - M_PI * i / kAcross;
      double x = width * std::cos(phi);
      if (i == 0 || i == kAcross || k == kAlong) x = 0;
      const double furrow = i == 0 ? -0.9 * (1 - s) : 0;
      const Vec3 p(x, middle_y + thick * std::sin(phi) + furrow, z);
      next.push_back(half.add(vertex(p, Tissue::tongue, -1)));
    }
    if (!ring.empty()) sew(half, Piece::tongue, next, ring, false);
    ring = std::move(next);
  }
}

}  // namespace

void add_mouth_parts(Sculpt& half) {
  for (const bool upper : {true, false}) {
    add_teeth(half, upper);
    add_gums(half, upper);
  }
  add_tongue(half);
}

}  // namespace mien::builtin_face
