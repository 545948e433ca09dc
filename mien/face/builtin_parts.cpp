#include <cmath>

#include "mien/core/random.h"
#include "mien/face/builtin_anatomy.h"
#include "mien/face/builtin_mesh.h"
#include "mien/face/builtin_surface.h"

namespace mien::face::builtin {
namespace {

using Ring = std::vector<std::uint32_t>;

SculptVertex vertex(const Vec3& p, Tissue tissue, double lip_side = 0) {
  SculptVertex v;
  v.p = v.anchor = p;
  v.tissue = tissue;
  v.lip_side = lip_side;
  return v;
}

/// Sews two rings; seen from outside, `a` to `b` goes up while the index goes right. `closed` joins last to
/// first.
void sew_up(Sculpt& half, Piece piece, const Ring& a, const Ring& b, bool closed) {
  for (std::size_t i = 0; i + (closed ? 0 : 1) < a.size(); ++i) {
    const std::size_t j = (i + 1) % a.size();
    half.quad(piece, a[i], a[j], b[j], b[i]);
  }
}

/// An outer ear on its own plane, turned out from the head: rim, ridge, bowl, tragus and lobe as relief on a
/// disc.
void add_ear(Sculpt& half) {
  const Vec3 root(72.5, 18, 1);
  const Vec3 back = Vec3(0.50, 0.06, -0.86).normalized();
  const Vec3 up = (Vec3(0.05, 1, -0.16) - Vec3(0.05, 1, -0.16).dot(back) * back).normalized();
  const Vec3 out = up.cross(back).normalized() * -1.0;
  constexpr int kAround = 28;
  const auto place = [&](double rho, double phi, double depth) {
    // phi 0 points back, 90 degrees up.
    const double c = std::cos(phi), s = std::sin(phi);
    const double reach_back = mix(19, 13, smoothstep(0, -0.9, s));
    const double across = c > 0 ? reach_back : 9.5;
    const double along = s > 0 ? 30 : 29;
    return Vec3(root + back * (rho * across * c + 2.0 + 4.0 * s * (s > 0 ? 0.6 : -0.2)) +
                up * (rho * along * s + 3) + out * depth);
  };
  const auto relief = [](double rho, double phi) {
    const double s = std::sin(phi), c = std::cos(phi);
    const double front = smoothstep(0.3, 0.9, -c);  // toward the face
    const double lobe = smoothstep(-0.55, -0.9, s);
    const double rim = (1 - lobe) * (1 - 0.6 * front);
    double h = 4.2;
    h += rim * (3.0 * gauss((rho - 0.9) / 0.12) - 1.6 * gauss((rho - 0.72) / 0.1));
    h += (1 - lobe) * (1 - front) * 2.4 * gauss((rho - 0.54) / 0.12);
    h -= 6.5 * gauss(rho / 0.36) * (1 - 0.3 * lobe);
    h += 4.0 * gauss((rho - 0.62) / 0.22) * front * gauss((s + 0.1) / 0.45);  // tragus
    h -= 3.0 * smoothstep(0.8, 1.0, rho) * front;                             // sinks into the cheek
    return h;
  };
  Ring ring;
  const double rhos[] = {1.0, 0.93, 0.86, 0.78, 0.69, 0.6, 0.5, 0.39, 0.26, 0.12};
  for (const double rho : rhos) {
    Ring next;
    for (int i = 0; i < kAround; ++i) {
      const double phi = 2 * M_PI * i / kAround;
      next.push_back(half.add(vertex(place(rho, phi, relief(rho, phi)), Tissue::ear)));
    }
    if (!ring.empty()) sew_up(half, Piece::ears, ring, next, true);
    ring = std::move(next);
  }
  const std::uint32_t bottom = half.add(vertex(place(0, 0, relief(0, 0)), Tissue::ear));
  for (int i = 0; i < kAround; ++i) half.triangle(Piece::ears, ring[i], ring[(i + 1) % kAround], bottom);
  // The back: from the rim inwards to a stem that ends inside the head.
  ring.clear();
  for (int i = 0; i < kAround; ++i)
    ring.push_back(static_cast<std::uint32_t>(bottom - kAround * std::size(rhos) + i));
  const double backs[][2] = {{1.02, 2.0}, {0.95, -0.5}, {0.7, -4.0}, {0.45, -10.0}, {0.4, -20.0}};
  for (const auto& b : backs) {
    Ring next;
    for (int i = 0; i < kAround; ++i)
      next.push_back(half.add(vertex(place(b[0], 2 * M_PI * i / kAround, b[1]), Tissue::ear)));
    sew_up(half, Piece::ears, next, ring, true);
    ring = std::move(next);
  }
}

/// The dental arch in the horizontal plane, by the way along it from the midline (mm): place, and direction
/// outward.
struct ArchPoint {
  Vec3 p, out;
};
ArchPoint arch(double way, double half_width, double front_z, double depth, double y) {
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
  const double height_lower[] = {8.6, 8.8, 9.6, 8.4, 7.8, 7.2};
  const double gum_y = upper ? -25.4 : -43.6;
  const double half_width = upper ? 27 : 25.5, front = upper ? 100.5 : 98.0, depth = upper ? 40 : 38.5;
  double way = 0;
  constexpr int kAround = 8;
  for (int t = 0; t < 6; ++t) {
    const double width = upper ? width_upper[t] : width_lower[t];
    const double height = upper ? height_upper[t] : height_lower[t];
    const ArchPoint at = arch(way + 0.5 * width, half_width, front, depth, gum_y);
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
      if (!ring.empty())
        upper ? sew_up(half, piece, ring, next, true) : sew_up(half, piece, next, ring, true);
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
  const double gum_y = upper ? -25.4 : -43.6;
  const double half_width = upper ? 27 : 25.5, front = upper ? 100.5 : 98.0, depth = upper ? 40 : 38.5;
  const double grow = upper ? 1 : -1;  // away from the biting edge
  // Outward and upward over the cross-section, front edge of the teeth to the palate.
  const double section[][2] = {{0.0, -1.2}, {1.0, 0.6}, {1.2, 4.0}, {-2.0, 8.0}, {-8.0, 6.5}, {-9.0, -0.5}};
  Ring ring;
  constexpr int kSteps = 14;
  for (int k = 0; k <= kSteps; ++k) {
    const ArchPoint at = arch(46.0 * k / kSteps, half_width, front, depth, gum_y);
    Ring next;
    for (const auto& s : section) {
      Vec3 p = at.p + at.out * s[0] + Vec3(0, grow * s[1], 0);
      if (k == 0) p.x() = 0;
      next.push_back(half.add(vertex(p, tissue, upper ? 1 : -1)));
    }
    if (!ring.empty())
      upper ? sew_up(half, piece, next, ring, false) : sew_up(half, piece, ring, next, false);
    ring = std::move(next);
  }
}

void add_tongue(Sculpt& half) {
  // Half rings across, from the root to the tip; top first, round the left side, to the underside.
  constexpr int kAlong = 11, kAcross = 8;
  Ring ring;
  for (int k = 0; k <= kAlong; ++k) {
    const double s = static_cast<double>(k) / kAlong;
    const double z = mix(44, 92, s);
    const double width = 18 * std::pow(1 - std::pow(s, 3.2), 0.5) * mix(0.85, 1.0, std::min(1.0, 3 * s));
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
    if (!ring.empty()) sew_up(half, Piece::tongue, next, ring, false);
    ring = std::move(next);
  }
}

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
        (upper ? mix(6.0, 9.8, std::sin(M_PI * std::pow(s, 1.5))) : 3.6) * (1 + 0.1 * random.normal());
    const Vec3 forward = Vec3(fan * 0.55, upper ? -0.02 : -0.35, 1).normalized();
    const Vec3 curl = Vec3(fan * 0.9, upper ? 0.95 : -0.75, 0.55).normalized();
    const Vec3 middle = root + forward * length * 0.5;
    const Vec3 tip = middle + curl * length * 0.55;
    const Vec3 side = Vec3(1, 0, -0.3 * fan).normalized();
    add_hair(half, Piece::lashes, Tissue::lash, root, middle, tip, side, upper ? 0.5 : 0.32, upper ? 1 : -1);
  }
}

/// Height of the brow's middle at x.
double brow_y(double x) {
  return 54.0 + 5.6 * std::sin(M_PI * std::clamp((x - 8) / 66, 0.0, 1.0)) -
         0.0042 * std::max(0.0, x - 34) * (x - 34) * 2.6;
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
    if (!below.empty()) sew_up(half, Piece::hair, below, ring, false);
    below = std::move(ring);
  }
}

}  // namespace

void add_parts(Sculpt& half) {
  const Random random(0x6D69656EULL);
  add_ear(half);
  for (const bool upper : {true, false}) {
    add_teeth(half, upper);
    add_gums(half, upper);
  }
  add_tongue(half);
  add_lashes(half, random.fork("lashes"));
  add_brow(half, random.fork("brow"));
  add_scalp_hair(half, random.fork("hair"));
}

void add_eyeballs(Sculpt& whole) {
  constexpr int kAround = 20;
  constexpr double kPupil = 0.17, kIris = 0.50;  // polar angles, rad
  struct Circle {
    double angle;
    int band;  // 0 pupil, 1 iris, 2 sclera
  };
  std::vector<Circle> circles = {{kPupil, 0}, {kPupil, 1}, {0.27, 1}, {0.42, 1},
                                 {kIris, 1},  {kIris, 2},  {0.56, 2}};
  for (int i = 1; i <= 8; ++i) circles.push_back({mix(0.56, M_PI - 0.15, i / 8.0), 2});
  for (int e = 0; e < 2; ++e) {
    const double sign = e == 0 ? 1 : -1;
    const Vec3 centre(sign * kEyeCentre.x(), kEyeCentre.y(), kEyeCentre.z());
    Eyeball& eye = whole.eyes[static_cast<std::size_t>(e)];
    eye.first_vertex = static_cast<std::uint32_t>(whole.vertices.size());
    eye.centre_m = centre.cast<float>();
    const auto place = [&](double angle, double phi) {
      const double bulge = 0.55 * (1 - smoothstep(0.2, 0.62, angle));
      return Vec3(centre + (kEyeRadius + bulge) * Vec3(std::sin(angle) * std::cos(phi),
                                                       std::sin(angle) * std::sin(phi), std::cos(angle)));
    };
    const auto add = [&](const Vec3& p, int band, double angle) {
      SculptVertex v = vertex(p, Tissue::eyeball);
      // The band and the place in it, for paint.
      v.lid = band + std::clamp((angle - kPupil) / (kIris - kPupil), 0.0, 0.99);
      return whole.add(v);
    };
    const std::array<Piece, 3> pieces = e == 0 ? std::array{Piece::pupil_l, Piece::iris_l, Piece::sclera_l}
                                               : std::array{Piece::pupil_r, Piece::iris_r, Piece::sclera_r};
    const std::uint32_t front = add(place(0, 0), 0, 0);
    Ring ring;
    int band = 0;
    for (const Circle& circle : circles) {
      Ring next;
      for (int i = 0; i < kAround; ++i)
        next.push_back(add(place(circle.angle, 2 * M_PI * i / kAround), circle.band, circle.angle));
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
    const std::uint32_t back = add(centre - Vec3(0, 0, kEyeRadius), 2, M_PI);
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

}  // namespace mien::face::builtin
