#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"
#include "mien/builtin_face/surface.h"
#include "mien/core/random.h"

namespace mien::builtin_face {
namespace {

/// One tapering hair of two joints on the given root; it lies flat toward `side`.
void add_hair(Sculpt& half, Piece piece, Tissue tissue, const Vec3& root, const Vec3& middle, const Vec3& tip,
              const Vec3& side, double width, double lid) {
  const auto make = [&](const Vec3& p) {
    SculptVertex v = vertex(p, tissue, 1);
    v.anchor = root;
    v.lid = lid;
    return half.add(v);
  };
  const std::uint32_t a = make(root - side * width * 0.5), b = make(root + side * width * 0.5);
  const std::uint32_t c = make(middle - side * width * 0.35), d = make(middle + side * width * 0.35);
  const std::uint32_t e = make(tip);
  half.quad(piece, a, b, d, c);
  half.triangle(piece, c, d, e);
}

void add_lashes(Sculpt& half, Random random) {
  constexpr int kUpper = 26, kLower = 15;
  for (int i = 0; i < kUpper + kLower; ++i) {
    const bool upper = i < kUpper;
    const double s = upper ? (i + 0.8) / (kUpper + 0.6) : 0.18 + 0.8 * (i - kUpper + 0.5) / kLower;
    const double x = mix(kInnerCanthusX + 1.5, kOuterCanthusX - 0.2, s);
    const double y = upper ? upper_lid_y(x) : lower_lid_y(x);
    Vec3 out = Vec3(x, y, head_point_at(x, y).z()) - kEyeCentre;
    out.normalize();
    const Vec3 root = kEyeCentre + out * (kLidRadius - 0.5);
    const double fan = mix(-0.45, 0.85, s) + 0.12 * random.normal();
    const double length =
        (upper ? mix(6.0, 10.6, std::sin(M_PI * std::pow(s, 1.5))) : 3.6) * (1 + 0.1 * random.normal());
    const Vec3 forward = Vec3(fan * 0.55, upper ? -0.02 : -0.35, 1).normalized();
    const Vec3 curl = Vec3(fan * 0.9, upper ? 0.95 : -0.75, 0.55).normalized();
    const Vec3 middle = root + forward * length * 0.5;
    const Vec3 tip = middle + curl * length * 0.55;
    const Vec3 side = Vec3(1, 0, -0.3 * fan).normalized();
    add_hair(half, Piece::lashes, Tissue::lash, root, middle, tip, side, upper ? 0.5 : 0.32, upper ? 1 : -1);
  }
}

void add_brow(Sculpt& half, Random random) {
  constexpr int kHairs = 86;
  for (int i = 0; i < kHairs; ++i) {
    const double s = (i + random.uniform()) / kHairs;
    const double x = mix(11.5, 53.5, s);
    const double thick = mix(4.2, 1.2, s) * smoothstep(-0.12, 0.12, s);
    const double off = random.uniform(-1, 1);
    const double y = brow_y(x) + off * thick;
    const double rise = mix(1.3, -0.25, smoothstep(0, 0.55, s)) - 0.45 * off;
    const double length = mix(6.0, 7.5, std::sin(M_PI * s)) * (1 - 0.25 * s);
    const Vec3 direction = Vec3(1, rise, 0).normalized();
    const auto on_skin = [&](double way, double lift) {
      const Vec3 q = head_point_at(x + direction.x() * way, y + direction.y() * way);
      return Vec3(q + Vec3(0.35, 0.1, 0.93) * lift);
    };
    const Vec3 root = on_skin(0, 0.0), middle = on_skin(0.5 * length, 1.0), tip = on_skin(length, 0.5);
    const Vec3 side = Vec3(-direction.y(), direction.x(), 0);
    add_hair(half, Piece::brows, Tissue::brow, root, middle, tip, -side, 0.6, 0);
  }
}

/// Where hair begins, as a row, over the azimuth.
double hairline_row(double azimuth) {
  const double a = azimuth * 180 / M_PI;
  const double points[][2] = {{0, 91},   {11, 89},  {22, 92}, {32, 98},   {40, 95},  {48, 78}, {56, 60},
                              {63, 46},  {68, 20},  {71, 9},  {77, 6},    {81, 14},  {87, 44}, {98, 56},
                              {108, 50}, {118, 26}, {128, 2}, {145, -22}, {180, -36}};
  for (std::size_t i = 0; i + 1 < std::size(points); ++i)
    if (a <= points[i + 1][0])
      return mix(points[i][1], points[i + 1][1], smoothstep(points[i][0], points[i + 1][0], a));
  return points[std::size(points) - 1][1];
}

void add_scalp_hair(Sculpt& half, Random random) {
  constexpr int kColumns = 44, kRows = 9;
  std::vector<double> ragged;
  for (int c = 0; c <= kColumns; ++c) ragged.push_back(random.uniform(-1.6, 1.6));
  Ring below;
  for (int r = 0; r <= kRows; ++r) {
    const double v = r == 0 ? 0.0 : mix(0.035, 1.0, std::pow((r - 1.0) / (kRows - 1), 1.15));
    Ring ring;
    for (int c = 0; c <= kColumns; ++c) {
      // Closer together in front, where the edge is seen.
      const double share = static_cast<double>(c) / kColumns;
      const double azimuth = M_PI * share * mix(0.72, 1.0, share);
      const double row = mix(hairline_row(azimuth) + ragged[static_cast<std::size_t>(c)], kTopRow - 0.5, v);
      Vec3 p = head_point(azimuth, row);
      const Vec3 centre(0, 50, 5);
      const double full = smoothstep(0.0, 0.22, v);
      const double front = smoothstep(75, 20, azimuth * 180 / M_PI);
      const double strand = random.uniform(-1, 1);
      double lift = -1.5 + full * (6.0 + 9.0 * front * smoothstep(0.03, 0.2, v) * smoothstep(0.9, 0.3, v)) +
                    full * 0.8 * strand;
      if (r == 0) lift = -1.0;
      if (r == 1) lift = 1.2;
      p += (p - centre).normalized() * lift;
      if (c == 0 || c == kColumns) p.x() = 0;
      SculptVertex w = vertex(p, Tissue::hair, 1);
      w.colour = Vec3f::Constant(static_cast<float>(1 + 0.22 * strand));
      ring.push_back(half.add(w));
    }
    if (!below.empty()) sew(half, Piece::hair, below, ring, false);
    below = std::move(ring);
  }
}

}  // namespace

void add_hairs(Sculpt& half) {
  const Random random(0x6D69656EULL);
  add_lashes(half, random.fork("lashes"));
  add_brow(half, random.fork("brow"));
  add_scalp_hair(half, random.fork("hair"));
}

}  // namespace mien::builtin_face
