#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"
#include "mien/builtin_face/surface.h"

namespace mien::builtin_face {

namespace {

/// From the eyeball's centre to its surface (mm), by the angle from its axis: the cornea is a cap of a
/// smaller sphere (radius 8.2, apex 0.9 in front of the ball; real ones 7.8 and some 1.3, which no lid of one
/// sphere would clear).
double eye_radius(double angle_rad) {
  constexpr double kCorneaRadius = 8.2, kApex = kEyeRadius + 0.9, kCorneaCentre = kApex - kCorneaRadius;
  const double across = kCorneaCentre * std::sin(angle_rad);
  const double cornea =
      kCorneaCentre * std::cos(angle_rad) + std::sqrt(kCorneaRadius * kCorneaRadius - across * across);
  return -join(-cornea, -kEyeRadius, 0.2);
}

constexpr double kLastCircle = M_PI - 0.15;

/// How far from the middle of its chart a texture shows what lies at this angle from the axis: half of the
/// chart is iris. The back's last ring ends it, so that the cap behind it turns over.
double chart_radius(double angle_rad) {
  constexpr double kIris = 0.5;
  return angle_rad < kIris ? angle_rad
                           : std::min(1.0, mix(0.5, 1.0, (angle_rad - kIris) / (kLastCircle - kIris)));
}

}  // namespace

void add_eyeballs(Sculpt& whole) {
  constexpr int kAround = 20;
  constexpr double kPupil = 0.17, kIris = 0.50;  // polar angles, rad
  struct Circle {
    double angle;
    int band;  // 0 pupil, 1 iris, 2 sclera
  };
  std::vector<Circle> circles = {{kPupil, 0}, {kPupil, 1}, {0.27, 1},  {0.34, 1},
                                 {0.42, 1},   {kIris, 1},  {kIris, 2}, {0.56, 2}};
  for (int i = 1; i <= 8; ++i) circles.push_back({mix(0.56, kLastCircle, i / 8.0), 2});
  for (int e = 0; e < 2; ++e) {
    const double sign = e == 0 ? 1 : -1;
    const Vec3 centre(sign * kEyeCentre.x(), kEyeCentre.y(), kEyeCentre.z());
    face::Eyeball& eye = whole.eyes[static_cast<std::size_t>(e)];
    eye.first_vertex = static_cast<std::uint32_t>(whole.vertices.size());
    eye.centre_m = centre.cast<float>();
    const auto place = [&](double angle, double phi) {
      return Vec3(centre + eye_radius(angle) * Vec3(std::sin(angle) * std::cos(phi),
                                                    std::sin(angle) * std::sin(phi), std::cos(angle)));
    };
    const auto add = [&](const Vec3& p, int band, double angle, double phi) {
      SculptVertex v = vertex(p, Tissue::eyeball);
      v.chart = {chart_radius(angle), phi};
      // The band and the place in it, for paint.
      v.lid = band + std::clamp((angle - kPupil) / (kIris - kPupil), 0.0, 0.99);
      return whole.add(v);
    };
    const std::array<Piece, 3> pieces = e == 0 ? std::array{Piece::pupil_l, Piece::iris_l, Piece::sclera_l}
                                               : std::array{Piece::pupil_r, Piece::iris_r, Piece::sclera_r};
    const std::uint32_t front = add(place(0, 0), 0, 0, 0);
    Ring ring;
    int band = 0;
    for (const Circle& circle : circles) {
      Ring next;
      for (int i = 0; i < kAround; ++i) {
        const double phi = 2 * M_PI * i / kAround;
        next.push_back(add(place(circle.angle, phi), circle.band, circle.angle, phi));
      }
      for (int i = 0; i < kAround; ++i) {
        const int j = (i + 1) % kAround;
        if (ring.empty())
          whole.triangle(pieces[0], front, next[i], next[j]);
        else if (band == circle.band)
          whole.quad(pieces[static_cast<std::size_t>(band)], next[i], next[j], ring[j], ring[i]);
      }
      ring = std::move(next);
      band = circle.band;
    }
    const std::uint32_t back = add(centre - Vec3(0, 0, kEyeRadius), 2, M_PI, 0);
    for (int i = 0; i < kAround; ++i) whole.triangle(pieces[2], ring[i], back, ring[(i + 1) % kAround]);
    eye.vertex_count = static_cast<std::uint32_t>(whole.vertices.size()) - eye.first_vertex;
  }
  // One eye's mirror image is the other; the circles run the other way round.
  const std::uint32_t first_l = whole.eyes[0].first_vertex, first_r = whole.eyes[1].first_vertex;
  const std::uint32_t count = whole.eyes[0].vertex_count;
  whole.mirror.resize(whole.vertices.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    std::uint32_t partner = i;
    if (i > 0 && i + 1 < count) {
      const std::uint32_t circle = (i - 1) / kAround, k = (i - 1) % kAround;
      partner = 1 + circle * kAround + (kAround / 2 + kAround - k) % kAround;
    }
    whole.mirror[first_l + i] = first_r + partner;
    whole.mirror[first_r + i] = first_l + partner;
  }
}

}  // namespace mien::builtin_face
