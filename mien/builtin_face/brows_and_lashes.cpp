#include <array>
#include <cmath>
#include <span>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"
#include "mien/builtin_face/surface.h"
#include "mien/core/random.h"

namespace mien::builtin_face {
namespace {

/// What all pieces of one ribbon share.
struct Ribbon {
  Piece piece;
  Tissue tissue;
  double width;  ///< mm, at the root.
  double lid;    ///< As SculptVertex has it.
  int first_strand, strands;
};

/// A ribbon along `spine`, which grows at its first point and lies flat towards `side`.
void add_ribbon(Sculpt& half, const Ribbon& ribbon, std::span<const Vec3> spine, const Vec3& side,
                float shade) {
  std::uint32_t below = 0;
  for (std::size_t k = 0; k < spine.size(); ++k) {
    const double s = static_cast<double>(k) / static_cast<double>(spine.size() - 1);
    const auto make = [&](int edge) {
      SculptVertex v =
          vertex(spine[k] + side * (edge - 0.5) * ribbon.width * (1 - 0.35 * s), ribbon.tissue, 1);
      v.anchor = spine[0];
      v.lid = ribbon.lid;
      v.colour = Vec3f::Constant(shade);
      v.uv = {static_cast<float>(ribbon.first_strand + edge * ribbon.strands) / face::kStrandsPerUv,
              static_cast<float>(s)};
      return half.add(v);
    };
    const std::uint32_t a = make(0);
    make(1);
    if (k > 0) {
      half.triangle(ribbon.piece, below, below + 1, a + 1);
      half.triangle(ribbon.piece, below, a + 1, a);
    }
    below = a;
  }
}

/// From the eyeball's centre to the lid's margin at (x, y), unit. The margin lies on the lids' sphere, but
/// for the corners, where it meets the skin around.
Vec3 out_of_eye(double x, double y) {
  const double dx = x - kEyeCentre.x(), dy = y - kEyeCentre.y(), off2 = dx * dx + dy * dy;
  constexpr double kOnSphere = 0.9 * kLidRadius;
  if (off2 < kOnSphere * kOnSphere)
    return Vec3(dx, dy, std::sqrt(kLidRadius * kLidRadius - off2)).normalized();
  return (Vec3(x, y, head_point_at(x, y).z()) - kEyeCentre).normalized();
}

void add_lashes(Sculpt& half, Random random) {
  constexpr int kUpper = 44, kLower = 24;
  for (int i = 0; i < kUpper + kLower; ++i) {
    const bool upper = i < kUpper;
    const double s =
        upper ? (i + 0.5 + 0.3 * random.normal()) / kUpper : 0.16 + 0.82 * (i - kUpper + 0.5) / kLower;
    const double x = mix(kInnerCanthusX + 2.5, kOuterCanthusX - 0.3, std::clamp(s, 0.0, 1.0));
    const double y = upper ? upper_lid_y(x) : lower_lid_y(x);
    const Vec3 out = out_of_eye(x, y);
    const Vec3 root = kEyeCentre + out * (kLidRadius - 0.2);
    // Longest a little outside the middle; every third leans to its neighbour, as wet lashes do.
    const double lean = 0.16 * (i % 3 - 1) + 0.06 * random.normal();
    const double fan = mix(-0.55, 0.95, s) + lean;
    const double length = (upper ? mix(4.8, 9.0, std::sin(M_PI * std::pow(s, 1.4))) : mix(2.6, 4.2, s)) *
                          (1 + 0.12 * random.normal());
    const Vec3 begin = Vec3(fan * 0.35, upper ? -0.22 : -0.30, 1).normalized();
    const Vec3 end = Vec3(fan * 0.85, upper ? 1.05 : -0.75, upper ? 0.45 : 0.8).normalized();
    std::array<Vec3, 5> spine;
    spine[0] = root;
    for (std::size_t k = 1; k < spine.size(); ++k) {
      const double t = (static_cast<double>(k) - 0.5) / (spine.size() - 1);
      spine[k] = spine[k - 1] + ((1 - t) * begin + t * end).normalized() * length / (spine.size() - 1);
    }
    const Vec3 side = Vec3(1, 0, -0.3 * fan).normalized();
    const Ribbon ribbon{Piece::lashes,      Tissue::lash, upper ? 0.8 : 0.6,
                        upper ? 1.0 : -1.0, i * 3,        upper ? 3 : 2};
    add_ribbon(half, ribbon, spine, side, 1);
  }
}

/// Where the ray from the front at (x, y) meets the brow.
Vec3 brow_point(double x, double y) {
  return surface_along({x, y, 0}, Vec3::UnitZ(), {.from = 150, .most = 40, .share = 0.8, .near = 0.02},
                       head_distance);
}

void add_brow(Sculpt& half, Random random) {
  constexpr int kRibbons = 188, kStrands = 5;
  for (int i = 0; i < kRibbons; ++i) {
    // Sparser at the nose, where brows begin without an edge.
    const double s = std::pow((i + random.uniform()) / kRibbons, 0.85);
    const double x = mix(9.5, 54, s);
    // Full and loose at the nose, thin at the temple.
    const double thick = mix(4.3, 0.8, std::pow(s, 1.3)) * smoothstep(-0.22, 0.16, s);
    const double off = random.uniform(-1, 1);
    const double y = brow_y(x) + off * thick;
    // Upright at the nose; further out the upper hairs turn down and the lower ones up, to one ridge.
    const double rise = mix(1.25, -0.22, smoothstep(0, 0.5, s)) - 0.40 * off * smoothstep(0.05, 0.3, s) +
                        0.20 * random.normal();
    const double length = mix(5.2, 8.0, std::sin(M_PI * s)) * (1 - 0.3 * s) * (1 + 0.18 * random.normal());
    std::array<Vec3, 4> spine;
    for (std::size_t k = 0; k < spine.size(); ++k) {
      const double t = static_cast<double>(k) / (spine.size() - 1);
      const Vec3 direction = Vec3(1, rise * (1 - 0.45 * t), 0).normalized();
      const double way = t * length;
      const Vec3 q = brow_point(x + direction.x() * way, y + direction.y() * way);
      spine[k] = q + Vec3(0.3, 0.15, 0.93) * (0.25 + 0.75 * std::sin(M_PI * std::min(t, 0.75)));
    }
    const Vec3 along = (spine[3] - spine[0]).normalized();
    const Vec3 side = along.cross(Vec3(0.3, 0.15, 0.93)).normalized();
    const Ribbon ribbon{Piece::brows, Tissue::brow, 0.85 * mix(0.7, 1.0, smoothstep(0, 0.15, s)), 0,
                        i * kStrands, kStrands};
    add_ribbon(half, ribbon, spine, side, static_cast<float>(1 + 0.15 * random.normal()));
  }
}

}  // namespace

void add_brows_and_lashes(Sculpt& half) {
  const Random random(0x6D69656EULL);
  add_lashes(half, random.fork("lashes"));
  add_brow(half, random.fork("brow"));
}

}  // namespace mien::builtin_face
