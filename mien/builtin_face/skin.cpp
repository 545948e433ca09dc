#include <cmath>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/mesh.h"
#include "mien/builtin_face/surface.h"
#include "mien/core/units.h"

namespace mien::builtin_face {
namespace {

std::vector<double> column_azimuths() {
  std::vector<double> columns;
  for (int i = 0; i <= 10; ++i) columns.push_back(0.95 * i * kRadPerDeg);
  for (int i = 1; i <= 18; ++i) columns.push_back((9.5 + 1.8 * i) * kRadPerDeg);
  double step = 1.75;
  while (columns.back() < 180 * kRadPerDeg) {
    step = std::min(step * 1.16, columns.back() < 100 * kRadPerDeg ? 4.8 : 11.0);
    columns.push_back(columns.back() + step * kRadPerDeg);
  }
  // Stretch what lies behind the face so that the last column ends at the back exactly.
  const double front = columns[28];
  const double scale = (M_PI - front) / (columns.back() - front);
  for (double& c : columns)
    if (c > front) c = front + (c - front) * scale;
  columns.back() = M_PI;
  return columns;
}

std::vector<double> row_coordinates() {
  std::vector<double> rows;
  for (int i = 0; i < 8; ++i) rows.push_back(mix(kNeckRow, kThroatRow, i / 8.0));
  for (int i = 0; i < 12; ++i)  // closer together under the chin
    rows.push_back(mix(kChinRow, kThroatRow, std::pow(1 - i / 12.0, 1.4)));
  for (int i = 0; i < 15; ++i) rows.push_back(kChinRow + 3.0 * i);
  for (int i = 0; i < 22; ++i) rows.push_back(-15 + 1.5 * i);  // the nose
  for (int i = 0; i < 14; ++i) rows.push_back(18 + 3.0 * i);
  double step = 3.0;
  for (double row = kCrownRow; row < kTopRow - 8; row += step) {
    rows.push_back(row);
    step = std::min(step * 1.28, 14.0);
  }
  return rows;
}

constexpr std::size_t kFaceRow = 20;  ///< Index of the row at kChinRow; the next ones are 3 mm apart.

/// A block of the grid that a hole replaces: first and last row and column, as vertices.
struct Block {
  std::size_t row0, row1, column0, column1;
  [[nodiscard]] bool has_cell(std::size_t row, std::size_t column) const {
    return row >= row0 && row < row1 && column >= column0 && column < column1;
  }
  [[nodiscard]] bool has_inside(std::size_t row, std::size_t column) const {
    return row > row0 && row < row1 && (column > column0 || column0 == 0) && column < column1;
  }
};
constexpr Block kEyeBlock{kFaceRow + 37, kFaceRow + 48, 7, 28};   // y 18 to 51
constexpr Block kMouthBlock{kFaceRow + 1, kFaceRow + 15, 0, 17};  // y -57 to -15

double lip_side_at(double x, double y) {
  const double width = 4.0 + 2.7 * std::max(0.0, x - kMouthCornerX + 1);
  return std::clamp((y - lip_line_y(x)) / width, -1.0, 1.0);
}

std::uint32_t add_skin_vertex(Sculpt& half, const Vec3& p, Tissue tissue = Tissue::skin) {
  return half.add(vertex(p, tissue, lip_side_at(p.x(), p.y())));
}

/// Azimuth and row of the ray that head_point_at found `p` by.
Eigen::Vector2d chart_at(const Vec3& p, double row) {
  return {std::atan2(p.x(), p.z() - kAxisZ), row};
}

/// Inner rings of a hole in the grid lie in the hole's chart, by `inward` (0 to 1) towards its middle.
void lay_in_hole(Sculpt& half, const Ring& rim, const Ring& ring, double inward) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const std::uint32_t i : rim) middle += half.vertices[i].chart / static_cast<double>(rim.size());
  for (std::size_t i = 0; i < ring.size(); ++i)
    half.vertices[ring[i]].chart = half.vertices[rim[i]].chart * (1 - inward) + middle * inward;
}

/// The tears that stand on the lower lid's edge: a clear strip, hollow towards the eyeball.
void add_tear_film(Sculpt& half, const Ring& margin) {
  struct Step {
    double radius, rise;  // mm; from the margin along the ball
  };
  Ring ring;
  for (const Step step :
       {Step{kLidRadius - 0.75, 0.0}, Step{kEyeRadius + 0.55, 0.35}, Step{kEyeRadius + 0.1, 1.0}}) {
    Ring next;
    for (const std::uint32_t i : margin) {
      const Vec3 out = half.vertices[i].p - kEyeCentre;
      const Vec3 up = (Vec3::UnitY() - out * out.y() / out.squaredNorm()).normalized();
      SculptVertex v =
          vertex(kEyeCentre + (out + step.rise * up).normalized() * step.radius, Tissue::tear, 1);
      v.lid = half.vertices[i].lid;
      next.push_back(half.add(v));
    }
    if (!ring.empty()) sew(half, Piece::tears, ring, next, false);
    ring = std::move(next);
  }
}

/// The pink flesh in the inner corner of the eye.
void add_caruncle(Sculpt& half) {
  constexpr int kAround = 10, kRings = 4;
  const Vec3 middle(kInnerCanthusX + 2.9, kInnerCanthusY + 0.1, kEyeCentre.z() + 5.6);
  const Vec3 radii(2.9, 1.7, 2.0);
  const std::uint32_t front = half.add(vertex(middle + Vec3(0, 0, radii.z()), Tissue::caruncle));
  Ring ring;
  for (int k = 1; k <= kRings; ++k) {
    const double polar = 0.5 * M_PI * k / kRings;
    Ring next;
    for (int i = 0; i < kAround; ++i) {
      const double phi = 2 * M_PI * i / kAround;
      next.push_back(
          half.add(vertex(middle + radii.cwiseProduct(Vec3(std::sin(polar) * std::cos(phi),
                                                           std::sin(polar) * std::sin(phi), std::cos(polar))),
                          Tissue::caruncle)));
    }
    if (ring.empty())
      for (int i = 0; i < kAround; ++i)
        half.triangle(Piece::caruncles, front, next[i], next[(i + 1) % kAround]);
    else
      sew(half, Piece::caruncles, next, ring, true);
    ring = std::move(next);
  }
}

using Grid = std::vector<std::vector<std::uint32_t>>;

/// How far the upper lid's skin stands out (mm) by rings from its crease: the fold above hangs over it.
double fold_mm(int rings_below_crease) {
  constexpr double kFold[] = {0.35, 0.7, 0.65, -0.5, -0.1};  // from three rings above
  const int i = rings_below_crease + 3;
  return i < 0 || i >= static_cast<int>(std::size(kFold)) ? 0 : kFold[i];
}

void add_eye(Sculpt& half, const Grid& grid) {
  // The block's border, counter-clockwise from the middle of its nasal side.
  const Block b = kEyeBlock;
  const std::size_t middle = (b.row0 + b.row1) / 2;
  Ring ring;
  for (std::size_t r = middle; r > b.row0; --r) ring.push_back(grid[r][b.column0]);
  for (std::size_t c = b.column0; c < b.column1; ++c) ring.push_back(grid[b.row0][c]);
  for (std::size_t r = b.row0; r < middle; ++r) ring.push_back(grid[r][b.column1]);
  const std::size_t outer_corner = ring.size();
  for (std::size_t r = middle; r < b.row1; ++r) ring.push_back(grid[r][b.column1]);
  for (std::size_t c = b.column1; c > b.column0; --c) ring.push_back(grid[b.row1][c]);
  for (std::size_t r = b.row1; r > middle; --r) ring.push_back(grid[r][b.column0]);
  const std::size_t n = ring.size();

  std::vector<Eigen::Vector2d> border(n), margin(n);
  std::vector<double> side(n);  // 1 upper lid, -1 lower, 0 at the corners
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& p = half.vertices[ring[i]].p;
    border[i] = {p.x(), p.y()};
    const bool lower = i <= outer_corner;
    const double s = lower ? static_cast<double>(i) / static_cast<double>(outer_corner)
                           : static_cast<double>(n - i) / static_cast<double>(n - outer_corner);
    // Closer together at the corners, where the margin turns.
    const double even = 0.5 - 0.5 * std::cos(M_PI * s);
    const double x = mix(kInnerCanthusX, kOuterCanthusX, mix(s, even, 0.45));
    margin[i] = {x, lower ? lower_lid_y(x) : upper_lid_y(x)};
    side[i] = (lower ? -1 : 1) * std::pow(std::sin(M_PI * s), 0.5);
  }
  // The upper lid's crease, and what answers to it on the lower.
  std::vector<Eigen::Vector2d> crease(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double s = std::abs(side[i]);
    const Eigen::Vector2d out = (border[i] - margin[i]).normalized();
    const Eigen::Vector2d up(0.12, side[i] > 0 ? 1 : -1);
    crease[i] = margin[i] + mix(1.3, side[i] > 0 ? 3.0 : 4.2, s * s) * ((1 - s) * out + s * up).normalized();
  }
  constexpr int kRings = 9, kCrease = 6;
  for (int k = 1; k <= kRings; ++k) {
    const double f = 1 - std::pow(1 - static_cast<double>(k) / kRings, 1.45);
    const double to_crease = 1 - std::pow(1 - std::min(1.0, static_cast<double>(k) / kCrease), 1.45);
    const double to_margin = std::max(0.0, static_cast<double>(k - kCrease) / (kRings - kCrease));
    Ring next(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d at =
          (1 - to_margin) * ((1 - to_crease) * border[i] + to_crease * crease[i]) + to_margin * margin[i];
      Vec3 p = head_point_at(at.x(), at.y());
      const Eigen::Vector2d chart = chart_at(p, at.y());
      p += (p - kEyeCentre).normalized() * fold_mm(k - kCrease) * smoothstep(0.55, 1.0, side[i]) *
           smoothstep(21, 30, p.x());
      if (k == kRings) {
        // The margin stands on the lids' own sphere; at the corners it meets the surrounding skin.
        const Vec3 out = (p - kEyeCentre).normalized();
        const double beyond = 2.6 * smoothstep(0.16, 0.0, lid_fraction(margin[i].x()));  // about the caruncle
        p = kEyeCentre + out * std::clamp((p - kEyeCentre).norm(), kLidRadius - 0.2, kLidRadius + beyond);
      }
      next[i] = add_skin_vertex(half, p);
      half.vertices[next[i]].chart = chart;
      half.vertices[next[i]].lid = side[i] >= 0 ? f * std::min(1.0, std::abs(side[i]) * 1.6 + 0.02)
                                                : -f * std::min(1.0, std::abs(side[i]) * 1.6 + 0.02);
    }
    sew(half, Piece::skin, ring, next, true);
    ring = std::move(next);
  }
  Ring tear_edge;  // The lower lid's margin, nasal to temporal.
  for (std::size_t i = 1; i < outer_corner; ++i) tear_edge.push_back(ring[i]);
  // The lid's edge, and its inside, which hugs the eyeball and ends deep beside it.
  struct Inner {
    double radius, back, inward;
  };
  const Ring rim = ring;
  for (const Inner inner : {Inner{kEyeRadius + 0.35, 0.3, 0.2}, Inner{kEyeRadius + 0.3, 4.0, 0.5},
                            Inner{kEyeRadius + 0.6, 11.0, 0.8}}) {
    Ring next(n);
    for (std::size_t i = 0; i < n; ++i) {
      Vec3 out = half.vertices[ring[i]].p - kEyeCentre;
      out.z() -= inner.back;
      next[i] = add_skin_vertex(half, kEyeCentre + out.normalized() * inner.radius, Tissue::lid_inside);
      half.vertices[next[i]].lid = half.vertices[ring[i]].lid;
    }
    sew(half, Piece::lids, ring, next, true);
    lay_in_hole(half, rim, next, inner.inward);
    ring = std::move(next);
  }
  add_tear_film(half, tear_edge);
  add_caruncle(half);
}

void add_mouth(Sculpt& half, const Grid& grid) {
  const Block b = kMouthBlock;
  const std::size_t corner_row = kFaceRow + 9;  // y -33
  Ring ring;
  for (std::size_t c = 0; c < b.column1; ++c) ring.push_back(grid[b.row0][c]);
  for (std::size_t r = b.row0; r < corner_row; ++r) ring.push_back(grid[r][b.column1]);
  const std::size_t corner = ring.size();
  for (std::size_t r = corner_row; r < b.row1; ++r) ring.push_back(grid[r][b.column1]);
  for (std::size_t c = b.column1 + 1; c > 0; --c) ring.push_back(grid[b.row1][c - 1]);
  const std::size_t n = ring.size();

  std::vector<Eigen::Vector2d> border(n), red(n), meet(n);
  std::vector<double> side(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& p = half.vertices[ring[i]].p;
    border[i] = {p.x(), p.y()};
    const bool lower = i < corner;
    const double s = lower ? static_cast<double>(i) / static_cast<double>(corner)
                           : static_cast<double>(n - 1 - i) / static_cast<double>(n - 1 - corner);
    const double spread = mix(s, std::sin(0.5 * M_PI * s), 0.4);
    const double x_red = (kMouthCornerX + 0.8) * spread;
    const double x_meet = (kMouthCornerX - 0.4) * spread;
    if (i == corner) {
      red[i] = {x_red, lip_line_y(x_red)};
      meet[i] = {x_meet, lip_line_y(x_meet)};
      continue;
    }
    red[i] = {x_red, lower ? std::min(lower_lip_border_y(x_red), lip_line_y(x_red) - 0.15)
                           : std::max(upper_lip_border_y(x_red), lip_line_y(x_red) + 0.15)};
    meet[i] = {x_meet, lip_line_y(x_meet) + (lower ? -0.06 : 0.06)};
    side[i] = (lower ? -1 : 1) * std::min(1.0, 2.2 * (1 - s) + 0.15);
  }
  constexpr int kOuter = 8, kRed = 6;
  for (int k = 1; k <= kOuter + kRed; ++k) {
    Ring next(n);
    const bool outside = k <= kOuter;
    const double f = outside ? 1 - std::pow(1 - static_cast<double>(k) / kOuter, 1.25)
                             : std::pow(static_cast<double>(k - kOuter) / kRed, 0.85);
    for (std::size_t i = 0; i < n; ++i) {
      const Eigen::Vector2d at = outside ? Eigen::Vector2d((1 - f) * border[i] + f * red[i])
                                         : Eigen::Vector2d((1 - f) * red[i] + f * meet[i]);
      next[i] = add_skin_vertex(half, head_point_at(std::max(at.x(), 0.0), at.y()),
                                outside ? Tissue::skin : Tissue::lip);
      SculptVertex& v = half.vertices[next[i]];
      v.chart = chart_at(v.p, at.y());
      if (i == 0 || i + 1 == n) v.p.x() = v.anchor.x() = v.chart.x() = 0;
      v.lip_side = mix(v.lip_side, side[i], outside ? smoothstep(0.3, 1, f) : 1.0);
    }
    sew(half, outside ? Piece::skin : Piece::lips, ring, next, false);
    ring = std::move(next);
  }
  // Inside: over the back of the lips, up into the furrow before the gums, and back round the cheeks to the
  // throat.
  std::vector<Vec3> edge(n);
  for (std::size_t i = 0; i < n; ++i) edge[i] = half.vertices[ring[i]].p;
  struct Step {
    double back, away, widen;
  };
  constexpr Step kSteps[] = {{2.2, -0.1, 1.0}, {4.6, 1.2, 1.02}, {5.8, 4.5, 1.06},
                             {7.2, 9.0, 1.14}, {12, 13, 1.25},   {22, 14, 1.38},
                             {36, 14, 1.52},   {50, 13, 1.4},    {62, 9, 1.0}};
  for (const Step step : kSteps) {
    Ring next(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double s = std::min(edge[i].x() / kMouthCornerX, 1.0);
      const double upward = side[i] * std::sqrt(std::max(0.0, 1 - 0.85 * s * s));
      Vec3 p(edge[i].x() * step.widen, edge[i].y() + upward * step.away,
             edge[i].z() - step.back * mix(1.0, 0.75, s));
      next[i] = add_skin_vertex(half, p, Tissue::mouth);
      half.vertices[next[i]].lip_side = side[i];
    }
    sew(half, Piece::mouth, ring, next, false);
    ring = std::move(next);
  }
  const std::uint32_t throat = add_skin_vertex(half, Vec3(0, lip_line_y(0), edge[0].z() - 76), Tissue::mouth);
  half.vertices[throat].lip_side = 0;
  for (std::size_t i = 0; i + 1 < n; ++i) half.triangle(Piece::mouth, ring[i], ring[i + 1], throat);
}

}  // namespace

void add_skin(Sculpt& half) {
  half.vertices.reserve(1 << 14);
  const std::vector<double> columns = column_azimuths();
  const std::vector<double> rows = row_coordinates();
  Grid grid(rows.size(), std::vector<std::uint32_t>(columns.size()));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (kEyeBlock.has_inside(r, c) || kMouthBlock.has_inside(r, c)) continue;
      grid[r][c] = add_skin_vertex(half, head_point(columns[c], rows[r]));
      half.vertices[grid[r][c]].chart = {columns[c], rows[r]};
      if (c == 0 || c + 1 == columns.size()) {
        SculptVertex& v = half.vertices[grid[r][c]];
        v.p.x() = v.anchor.x() = 0;
      }
    }
  }
  for (std::size_t r = 0; r + 1 < rows.size(); ++r)
    for (std::size_t c = 0; c + 1 < columns.size(); ++c)
      if (!kEyeBlock.has_cell(r, c) && !kMouthBlock.has_cell(r, c))
        half.quad(Piece::skin, grid[r][c], grid[r][c + 1], grid[r + 1][c + 1], grid[r + 1][c]);
  Vec3 top = head_point(0, kTopRow);
  top.x() = 0;
  const std::uint32_t crown = add_skin_vertex(half, top);
  half.vertices[crown].chart = {0, kTopRow};
  for (std::size_t c = 0; c + 1 < columns.size(); ++c)
    half.triangle(Piece::skin, grid.back()[c], grid.back()[c + 1], crown);
  add_eye(half, grid);
  add_mouth(half, grid);
}

Sculpt mirrored(const Sculpt& half) {
  Sculpt whole = half;
  const std::size_t n = half.vertices.size();
  whole.vertices.reserve(2 * n + 1024);  // Eyeballs come after.
  whole.mirror.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (half.vertices[i].p.x() == 0) {
      whole.mirror[i] = static_cast<std::uint32_t>(i);
      continue;
    }
    SculptVertex v = half.vertices[i];
    v.p.x() = -v.p.x();
    v.anchor.x() = -v.anchor.x();
    whole.mirror[i] = whole.add(v);
    whole.mirror.push_back(static_cast<std::uint32_t>(i));
  }
  for (auto& piece : whole.triangles) {
    const std::size_t count = piece.size();
    for (std::size_t t = 0; t < count; ++t)
      piece.push_back({whole.mirror[piece[t][0]], whole.mirror[piece[t][2]], whole.mirror[piece[t][1]]});
  }
  return whole;
}

}  // namespace mien::builtin_face
