#include <algorithm>
#include <cmath>
#include <string_view>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/expression.h"
#include "mien/core/toml.h"
#include "mien/face/profile.h"

namespace mien::builtin_face {

extern const std::string_view kSkinChangesToml;  // skin_changes.toml.

namespace {

/// What a shape at weight 1 does to the skin at a site: skin_changes.toml.
struct SkinChange {
  Vec3 turn_deg;         ///< Rotation vector, frame H.
  Vec3 stretch_percent;  ///< Across the face, up, and the shear between them, in the skin's plane.
  double reach_mm;       ///< How far what is added reaches.
  double swell_mm;  ///< Pivot this far below the skin's own middle, so that the turned skin swells outward.
};

/// What `shape` (without side; its left one, if it has sides) does to the skin at this site.
SkinChange change_wanted(std::string_view shape, std::string_view site, bool one_sided) {
  static const toml::table shapes = parse_toml(kSkinChangesToml, "skin_changes.toml").value();
  auto row = shapes[shape][site];
  bool is_mirrored = false;
  if (!row && (site.ends_with("_L") || (site.ends_with("_R") && !one_sided))) {
    row = shapes[shape][site.substr(0, site.size() - 2)];
    is_mirrored = row && site.ends_with("_R");
  }
  const auto vector = [&row](std::string_view key) {
    return Vec3(row[key][0].value_or(0.0), row[key][1].value_or(0.0), row[key][2].value_or(0.0));
  };
  SkinChange change{.turn_deg = vector("turn_deg"),
                    .stretch_percent = vector("stretch_percent"),
                    .reach_mm = row["reach_mm"].value_or(row ? 17.0 : 14.0),
                    .swell_mm = row["swell_mm"].value_or(0.0)};
  if (is_mirrored) {
    // In the mirror a turn about x keeps its sign, about y and z it changes.
    change.turn_deg.y() *= -1;
    change.turn_deg.z() *= -1;
    change.stretch_percent.z() *= -1;
  }
  return change;
}

using Tangents = Eigen::Matrix<double, 3, 2>;

/// A patch of skin about a sensor's site: points spread evenly over the surface within 5 mm, each a place in
/// a triangle.
struct SkinPatch {
  struct Point {
    std::array<std::uint32_t, 3> corner;
    Vec3 weight;  ///< Barycentric.
    double area_mm2;
  };
  std::vector<Point> points;
};

SkinPatch skin_patch(const Sculpt& whole, const Vec3& site_mm, double radius_mm = 5) {
  SkinPatch patch;
  constexpr int kSplit = 4;
  for (const auto& t : whole.triangles[static_cast<std::size_t>(Piece::skin)]) {
    const Vec3 &a = whole.vertices[t[0]].p, &b = whole.vertices[t[1]].p, &c = whole.vertices[t[2]].p;
    const double reach = radius_mm + std::max((a - b).norm(), (a - c).norm());
    if ((a - site_mm).squaredNorm() > reach * reach) continue;
    const double area = 0.5 * (b - a).cross(c - a).norm() / (kSplit * kSplit);
    for (int i = 0; i < kSplit; ++i) {
      for (int j = 0; j < 2 * (kSplit - i) - 1; ++j) {
        // Centres of the small triangles, row by row.
        const int k = j / 2;
        const double third = j % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
        const double u = (i + third) / kSplit, w = (k + third) / kSplit;
        const Vec3 weight(1 - u - w, u, w);
        const Vec3 p = weight.x() * a + weight.y() * b + weight.z() * c;
        if ((p - site_mm).norm() <= radius_mm) patch.points.push_back({t, weight, area});
      }
    }
  }
  return patch;
}

/// The skin under one sensor.
struct Place {
  SkinPatch patch;
  Vec3 centre, normal;
  Tangents tangents;                  ///< Across the face and up, unit.
  std::vector<std::uint32_t> around;  ///< Soft vertices within kFarthest_mm.
};
constexpr double kFarthest_mm = 20;  ///< No reach_mm is more.

Vec3 patch_normal(const Sculpt& whole, const SkinPatch& patch) {
  Vec3 sum = Vec3::Zero();
  for (const SkinPatch::Point& point : patch.points) {
    const Vec3 &a = whole.vertices[point.corner[0]].p, &b = whole.vertices[point.corner[1]].p,
               &c = whole.vertices[point.corner[2]].p;
    sum += point.area_mm2 * (b - a).cross(c - a).normalized();
  }
  return sum.normalized();
}

Place place_at(const Sculpt& whole, const Vec3& centre) {
  Place place{
      .patch = skin_patch(whole, centre), .centre = centre, .normal = {}, .tangents = {}, .around = {}};
  place.normal = patch_normal(whole, place.patch);
  const Vec3 across = (Vec3::UnitX() - place.normal.x() * place.normal).normalized();
  const Vec3 up = place.normal.cross(across);
  place.tangents << across, (up.y() < 0 ? -up : up);
  for (std::uint32_t i = 0; i < whole.vertices.size(); ++i) {
    const SculptVertex& v = whole.vertices[i];
    const bool soft = v.tissue == Tissue::skin || v.tissue == Tissue::lip || v.tissue == Tissue::mouth ||
                      v.tissue == Tissue::brow;
    if (soft && (v.anchor - centre).norm() < kFarthest_mm) place.around.push_back(i);
  }
  return place;
}

/// How the displacement grows along the skin: least squares over the patch; a column a tangent.
Tangents gradient(const Sculpt& whole, const Place& place, std::span<const Vec3> displacement) {
  Tangents products = Tangents::Zero();
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  Vec3 mean_d = Vec3::Zero();
  Eigen::Vector2d mean_p = Eigen::Vector2d::Zero();
  double area = 0;
  for (const SkinPatch::Point& point : place.patch.points) {
    Vec3 p = -place.centre, d = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      p += point.weight[k] * whole.vertices[point.corner[static_cast<std::size_t>(k)]].p;
      d += point.weight[k] * displacement[point.corner[static_cast<std::size_t>(k)]];
    }
    const Eigen::Vector2d along = place.tangents.transpose() * p;
    products += point.area_mm2 * d * along.transpose();
    spread += point.area_mm2 * along * along.transpose();
    mean_d += point.area_mm2 * d;
    mean_p += point.area_mm2 * along;
    area += point.area_mm2;
  }
  const Tangents together = products - mean_d * mean_p.transpose() / area;
  return together * (spread - mean_p * mean_p.transpose() / area).inverse();
}

/// The same of skin that is first stretched and then turned.
Tangents gradient_of(const SkinChange& change, const Place& place) {
  const Vec3& percent = change.stretch_percent;
  Eigen::Matrix2d stretch;
  stretch << 100 + percent.x(), percent.z(), percent.z(), 100 + percent.y();
  const Quat turn = exp_rotation(change.turn_deg * M_PI / 180);
  return turn.toRotationMatrix() * place.tangents * (stretch / 100) - place.tangents;
}

/// What one shape should do at one place.
struct Aim {
  const Place* place;
  SkinChange change;
  Tangents wanted;  ///< gradient_of(change).
};

/// Adds a smooth field of this gradient to soft skin around the place; its normal turns along.
void add_gradient(const Sculpt& whole, const Place& place, const Tangents& gradient, const SkinChange& change,
                  std::vector<Vec3>& d) {
  const Vec3 tilt = place.tangents * (gradient.transpose() * place.normal);
  const Mat3 field = gradient * place.tangents.transpose() - tilt * place.normal.transpose();
  const Vec3 turn =
      0.5 * Vec3(field(2, 1) - field(1, 2), field(0, 2) - field(2, 0), field(1, 0) - field(0, 1));
  const Vec3 swell = turn.norm() > 0
                         ? Vec3(change.swell_mm * turn.cross(place.normal.cross(turn.normalized())))
                         : Vec3::Zero();
  for (const std::uint32_t i : place.around) {
    const SculptVertex& v = whole.vertices[i];
    const double q = (v.anchor - place.centre).squaredNorm() / (change.reach_mm * change.reach_mm);
    if (q >= 1) continue;
    const double w =
        (1 - q) * (1 - q) * (1 + 2 * q) * (1 - smoothstep(0.3, 0.8, std::abs(v.lid))) * off_canthi(v.anchor);
    d[i] += w * (field * (v.p - place.centre) - swell);
  }
}

}  // namespace

TuneShape kinematics_tuner(const Sculpt& whole) {
  std::vector<std::pair<std::string_view, Place>> places;
  for (const BuiltinSite& site : builtin_sites())
    if (site.name != "mastoid_L")  // No expression moves the reference.
      places.emplace_back(site.name, place_at(whole, site.position_m * 1000));
  return [&whole, places = std::move(places)](std::size_t shape, std::vector<Vec3>& d) {
    std::string_view name = face::kShapeNames[shape];
    const bool one_sided = name.ends_with("_L");
    if (one_sided) name.remove_suffix(2);
    std::vector<Aim> aims;
    for (const auto& [site, place] : places) {
      const SkinChange change = change_wanted(name, site, one_sided);
      aims.push_back({&place, change, gradient_of(change, place)});
    }
    // What is added at one site reaches the next: sweep over all until each has what it should.
    constexpr double kNear = 0.005;  // A third of a degree.
    for (int sweep = 0; sweep < 60; ++sweep) {
      double worst = 0;
      for (const Aim& aim : aims) {
        const Tangents missing = aim.wanted - gradient(whole, *aim.place, d);
        worst = std::max(worst, missing.norm());
        if (missing.norm() > 0.2 * kNear) add_gradient(whole, *aim.place, 0.9 * missing, aim.change, d);
      }
      if (worst < kNear) break;
    }
  };
}

}  // namespace mien::builtin_face
