#include "mien/builtin_face/surface.h"

#include <cmath>

#include "mien/builtin_face/anatomy.h"

namespace mien::builtin_face {

double ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& radii) {
  const Vec3 q = p - centre;
  const double k0 = q.cwiseQuotient(radii).norm();
  const double k1 = q.cwiseQuotient(radii.cwiseProduct(radii)).norm();
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -radii.minCoeff();
}

double capsule(const Vec3& p, const Vec3& a, double ra, const Vec3& b, double rb) {
  const Vec3 ab = b - a;
  const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (p - a - t * ab).norm() - mix(ra, rb, t);
}

double join(double a, double b, double k) {
  if (std::abs(a - b) >= k) return std::min(a, b);
  const double h = (k - std::abs(a - b)) / k;
  return std::min(a, b) - h * h * k * 0.25;
}

namespace {

double carve(double a, double b, double k) {
  return -join(-a, b, k);
}

constexpr double kNoseRows[] = {-15, 18};

/// Forms finer than bones: how far (mm) the skin stands out from head_distance's surface at a place of the
/// face.
double relief(const Vec3& p) {
  const double x = std::abs(p.x());
  const double y = p.y();
  if (p.z() < 40) return 0;
  double h = 0;
  // Lips: two cushions with a furrow where they meet.
  const double line = lip_line_y(x);
  const double s = std::min(x / kMouthCornerX, 1.0);
  const double body = std::pow(1 - s * s, 0.6);
  if (y > line) {
    const double top = upper_lip_border_y(x) - line + 0.4;
    const double u = (y - line) / top;
    if (u < 1) h += body * 2.6 * std::pow(std::sin(M_PI * std::pow(u, 0.75)), 0.8);
    h += body * 0.9 * gauss((y - line - top) / 3.5);
  } else {
    const double bottom = line - lower_lip_border_y(x) + 0.4;
    const double u = (line - y) / bottom;
    if (u < 1) h += body * 1.9 * std::pow(std::sin(M_PI * std::pow(u, 0.8)), 0.8);
  }
  h -= (2.6 * body + 1.3 * smoothstep(0.55, 1.0, s)) * gauss((y - line) / (1.6 + 1.5 * s)) *
       smoothstep(33, 26, x);
  // Philtrum between its two ridges.
  const double philtrum = smoothstep(-28, -23, y) * smoothstep(-10, -15, y);
  h += philtrum * (0.6 * gauss((x - 4.8) / 2.4) - 0.8 * gauss(x / 2.9));
  // Furrow between lip and chin, and the fold from nose to mouth corner.
  h -= 2.6 * gauss((y + 50 - 0.006 * x * x) / 5.0) * gauss(x / 19);
  const double along = std::clamp((-6 - y) / 28, 0.0, 1.0);
  const double fold_x = mix(18.5, 33.5, along);
  h -= 1.0 * gauss((x - fold_x) / 4.2) * smoothstep(-4, -12, y) * smoothstep(-42, -30, y);
  return h;
}

/// The nose on the face `d`; `q` is p on the left side, smooth across the midline.
double nose_joined(double d, const Vec3& p, const Vec3& q) {
  if (p.z() < 70) return d;
  // Bridge, its side walls, and the tip's two domes.
  double dorsum = capsule(p, {0, 40.7, 98.8}, 2.2, {0, 10.1, 118.3}, 7.3);
  dorsum = join(dorsum, ellipsoid(p, {0, 14.7, 100.3}, {10.1, 18, 13.4}), 9);
  dorsum = join(dorsum, ellipsoid(q, {2.5, 1.9, 120.6}, {7.6, 8.8, 10.3}), 7);
  dorsum = join(dorsum, ellipsoid(p, {0, 9.3, 109.6}, {13.1, 8.4, 10.4}), 6);
  d = join(d, dorsum, 8);
  // Wings, each in a groove of its own, and the columella between the nostrils.
  d = join(d, ellipsoid(q, {13.4, -2.4, 108.2}, {3.9, 6.6, 9.6}), 3.6);
  d = join(d, capsule(p, {0, -1.2, 118.9}, 3.6, {0, -11.4, 108.6}, 3.6), 4);
  return carve(d, ellipsoid(q, {7.9, -9.3, 114.5}, {3.2, 5.2, 6.4}), 1.4);
}

}  // namespace

double head_distance(const Vec3& p) {
  // Paired parts are written once, on the left; the rounded corner keeps them smooth across the midline.
  const Vec3 q(std::sqrt(p.x() * p.x() + 25) - 1.5, p.y(), p.z());
  // Braincase and forehead.
  double d = ellipsoid(p, {0, 54, -3.9}, {81.1, 93, 83.5});
  d = join(d, ellipsoid(p, {0, 58.5, 29.9}, {71.6, 78.9, 75.9}), 14);
  // Middle face, cheekbones, flesh of the cheeks, upper jaw.
  d = join(d, ellipsoid(p, {0, -4.4, 42.6}, {68.5, 79.1, 60.4}), 22);
  d = join(d, capsule(q, {44.4, 3.4, 74.8}, 9.5, {51.5, 17.4, 51.9}, 8.6), 22);
  d = join(d, ellipsoid(q, {28.4, -25.4, 66.6}, {16, 32.9, 30.7}), 18);
  d = join(d, ellipsoid(p, {0, -28.3, 77.5}, {26.2, 40, 39}), 18);
  // Lower jaw and chin.
  d = join(d, capsule(q, {45.5, 6.3, 18.5}, 11.5, {33, -35.6, 20.6}, 11.3), 28);
  const Vec3 other(-p.x(), p.y(), p.z());
  const double mandible = join(capsule(p, {34.7, -30.3, 32.7}, 15.1, {10.8, -61.5, 81.9}, 16),
                               capsule(other, {34.7, -30.3, 32.7}, 15.1, {10.8, -61.5, 81.9}, 16), 12);
  d = join(d, mandible, 26);
  d = join(d, ellipsoid(p, {0, -67.8, 95.7}, {14.6, 7, 11.1}), 15);
  d = join(d, ellipsoid(p, {0, -69.7, 38.8}, {23.2, 38.2, 19.1}), 18);
  // Neck, widening to the shoulders.
  double neck = capsule(p, {0, -10.7, -2.9}, 53.1, {0, -240.8, -13.7}, 52);
  neck = join(neck, capsule(q, {24, -150, -38}, 40, {84, -240, -44}, 38), 40);
  neck = join(neck, capsule(q, {57, -22, -10}, 8, {12, -185, 42}, 8), 24);
  d = join(d, neck, 14);
  // Brow, eye socket, and the lids' bulge in it.
  double brow = capsule(q, {16, 59.6, 92.6}, 9.5, {37.9, 50.2, 82.4}, 11.1);
  brow = join(brow, capsule(q, {37.9, 50.2, 82.4}, 11.1, {49.2, 44.4, 70}, 4.5), 6);
  d = join(d, brow, 16);
  d = carve(d, ellipsoid(q, {31, 35, 106}, {20, 12, 17}), 10);
  d = join(d, (q - kEyeCentre).norm() - kLidRadius, 5.0);
  d = join(d, ellipsoid(q, {33, 29, 84}, {16, 11, 11}), 8);
  return nose_joined(d, p, q);
}

Vec3 head_point(double azimuth_rad, double row) {
  double elevation = 0, origin_y = row;
  if (row > kNoseRows[0] && row < kNoseRows[1]) {
    // Downward through the nose's underside, which level rays would graze; the lines cross the face in the
    // order of their rows.
    const double under = smoothstep(kNoseRows[0], -9, row) * smoothstep(kNoseRows[1], 4, row);
    elevation = -0.48 * under * gauss(azimuth_rad / 0.21);
    origin_y = row - 101 * std::tan(elevation);
  }
  if (row > kCrownRow) {
    elevation = (row - kCrownRow) / 85;
    origin_y = kCrownRow;
  } else if (row < kChinRow) {
    constexpr double kSteepest = -50 * M_PI / 180;
    origin_y = kChinRow;
    if (row > kThroatRow) {
      elevation = kSteepest * (row - kChinRow) / (kThroatRow - kChinRow);
    } else {
      const double s = (row - kThroatRow) / (kNeckRow - kThroatRow);
      elevation = kSteepest * (1 - s);
      origin_y = mix(kChinRow, -195, s);
    }
  }
  const Vec3 direction(std::sin(azimuth_rad) * std::cos(elevation), std::sin(elevation),
                       std::cos(azimuth_rad) * std::cos(elevation));
  const Vec3 origin(0, origin_y, kAxisZ);
  double r = 175;
  double outside = r;
  for (int i = 0; i < 200; ++i) {
    const double d = head_distance(origin + r * direction);
    if (d < 0.01) break;
    outside = r;
    r -= std::max(0.75 * d, 0.02);
    if (r <= 0) return origin;
  }
  double inside = r;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (inside + outside);
    (head_distance(origin + middle * direction) < 0 ? inside : outside) = middle;
  }
  const Vec3 hit = origin + 0.5 * (inside + outside) * direction;
  return row > kCrownRow || row < kChinRow - 15 ? hit : Vec3(hit + relief(hit) * direction);
}

Vec3 head_point_at(double x, double y) {
  double z = 100;
  Vec3 p;
  for (int i = 0; i < 8; ++i) {
    p = head_point(std::atan2(x, z - kAxisZ), y);
    z = mix(z, p.z(), i < 3 ? 1.0 : 0.6);
  }
  return p;
}

}  // namespace mien::builtin_face
