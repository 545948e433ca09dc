#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "mien/builtin_face/anatomy.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/expression.h"
#include "mien/face/profile.h"

namespace mien::builtin_face {
namespace {

/// What real skin does under a sensor at weight 1, by shape without side, as measured on the ICT model and
/// rounded (docs/method/builtin_face.md has the source): how the patch turns, and how it is stretched before
/// it turns. Skin at a site that a shape does not name does neither. A site with a side belongs to it alone;
/// one without stands for the left, and for the right as its mirror image where the shape has no side.
struct SkinChange {
  std::string_view shape, site;
  Vec3 turn_deg;         ///< Rotation vector, frame H.
  Vec3 stretch_percent;  ///< Across the face, up, and the shear between them, in the skin's plane.
  double reach_mm = 17;  ///< How far what is added reaches.
  double swell_mm =
      0;  ///< Pivot this far below the skin's own middle, so that the turned skin swells outward.
};
const SkinChange kSkin[] = {
    {"browDown", "frontalis", {1, -4.5, -7}, {-10, 14, 6}},
    {"browDown", "orbicularis", {1, 0, 0}, {0, 0, -2}, 14},
    {"browInnerUp", "frontalis", {-0.5, 1.5, -4.5}, {0, -8, -4}},
    {"browOuterUp", "frontalis", {6, 1.5, 2.5}, {8, -28, 4}},
    {"browOuterUp", "orbicularis", {2, -1, 0.5}, {-2, 6, 0}, 14},
    {"cheekPuff", "zygomaticus_upper", {-12, -2, 5.5}, {0, -4, 0}, 15},
    {"cheekPuff", "zygomaticus_lower", {-11.5, -2, 4}, {20, 10, 10}},
    {"cheekPuff", "buccinator", {0, -4, -1}, {28, 8, 2}, 14},
    {"cheekPuff", "orbicularis", {-3.5, -0.5, 0.5}, {-2, -10, 4}, 14},
    {"cheekPuff", "mentalis", {-0.5, -1.5, 2}, {0, 0, 4}, 14},
    {"cheekSquint", "zygomaticus_lower", {7, -7.5, 3}, {-6, 4, 2}, 20, 5},
    {"cheekSquint", "zygomaticus_upper", {-3, -1, 6.5}, {-4, 0, 2}, 14},
    {"cheekSquint", "buccinator", {2, -4.5, 2}, {-6, 6, 10}, 14},
    {"cheekSquint", "orbicularis", {-2.5, -1, 1}, {-6, -24, 10}, 14},
    {"cheekSquint", "mentalis", {-0.5, -0.5, 0}, {0, 0, 0}, 14},
    {"eyeBlink", "orbicularis", {1, 1.5, -1}, {0, 0, 0}},
    {"eyeLookDown", "orbicularis", {-1, -2.5, 2.5}, {-2, 0, 2}},
    {"eyeLookDown", "zygomaticus_upper", {-0.5, 0, 0}, {0, 0, 0}, 14},
    {"eyeLookIn", "orbicularis", {3, 1, 0}, {8, -2, -2}},
    {"eyeLookIn", "zygomaticus_upper", {0.5, 0, 0.5}, {0, 0, 0}, 14},
    {"eyeLookOut", "orbicularis", {-3.5, -2, 1}, {-8, 2, 0}},
    {"eyeLookUp", "orbicularis", {-0.5, 1, -1.5}, {0, 2, -2}},
    {"eyeSquint", "orbicularis", {0, -1, -4.5}, {4, -12, 2}},
    {"eyeSquint", "zygomaticus_upper", {1, -0.5, 2}, {2, 6, -4}, 14},
    {"eyeSquint", "zygomaticus_lower", {0, -0.5, 1}, {-2, 2, 0}, 14},
    {"eyeSquint", "buccinator", {0.5, -0.5, 0.5}, {0, 2, 0}, 14},
    {"eyeWide", "orbicularis", {0, 0, -0.5}, {0, 2, 0}},
    {"jawForward", "buccinator", {-9.5, 0, 6.5}, {8, 2, 4}},
    {"jawForward", "zygomaticus_lower", {-7.5, 0, 3.5}, {0, 2, 2}, 15},
    {"jawForward", "zygomaticus_upper", {0.5, -0.5, -0.5}, {0, 0, 2}, 14},
    {"jawForward", "orbicularis", {0, 0, -0.5}, {0, 0, 0}, 14},
    {"jawForward", "mentalis", {0, 0, 0}, {4, 0, 0}, 14},
    {"jawLeft", "buccinator_L", {-3, 2, 8.5}, {-4, -2, -4}},
    {"jawLeft", "buccinator_R", {1.5, 2.5, 6}, {4, 0, -4}},
    {"jawLeft", "zygomaticus_lower_L", {-1.5, 2.5, 4}, {0, -2, -4}, 14},
    {"jawLeft", "zygomaticus_lower_R", {1, 1, 3.5}, {0, 2, -4}, 14},
    {"jawLeft", "mentalis", {0, 1, 0}, {0, 0, 0}, 14},
    {"jawLeft", "zygomaticus_upper_R", {0.5, 0, 1}, {-2, 0, -2}, 14},
    {"jawLeft", "zygomaticus_upper_L", {0.5, 0, 0.5}, {0, 0, -2}, 14},
    {"jawLeft", "orbicularis_R", {0, 0, 0.5}, {0, 0, 0}, 14},
    {"jawOpen", "zygomaticus_lower", {14.5, 8, -6}, {-6, 28, -2}, 20},
    {"jawOpen", "buccinator", {15.5, -1.5, 2.5}, {-4, 24, 8}, 16},
    {"jawOpen", "zygomaticus_upper", {5.5, -0.5, -3.5}, {0, 10, -2}, 15},
    {"jawOpen", "mentalis", {5.5, 0, 0}, {10, -14, 0}, 15},
    {"jawOpen", "orbicularis", {0.5, 0, -1}, {0, 8, -2}, 14},
    {"mouthClose", "buccinator", {-18.5, 11, -3}, {24, -22, -18}},
    {"mouthClose", "zygomaticus_lower", {-17, -1, 9.5}, {4, -26, 4}, 16},
    {"mouthClose", "mentalis", {3.5, 0, 0}, {0, 42, 0}, 15},
    {"mouthDimple", "buccinator", {5.5, -25.5, -16.5}, {-6, -10, -4}},
    {"mouthDimple", "zygomaticus_lower", {19, -20.5, -6.5}, {-22, -2, -8}, 15},
    {"mouthDimple", "zygomaticus_upper", {-11.5, 2, 3.5}, {2, -4, 0}, 14},
    {"mouthDimple", "mentalis", {-6.5, 0, 1}, {6, -2, 2}, 14},
    {"mouthFrown", "buccinator", {-0.5, -8.5, 8.5}, {-4, 0, 10}},
    {"mouthFrown", "zygomaticus_lower", {5.5, -7.5, 3.5}, {-12, 14, 0}, 14},
    {"mouthFrown", "mentalis", {0.5, -1.5, 0.5}, {0, 0, 2}, 14},
    {"mouthFrown", "zygomaticus_upper", {1.5, -0.5, -1}, {0, 4, 2}, 14},
    {"mouthFrown", "orbicularis", {-0.5, -0.5, -0.5}, {0, 2, 0}, 14},
    {"mouthFunnel", "zygomaticus_lower", {-3, 5.5, -2.5}, {6, 0, 12}},
    {"mouthFunnel", "buccinator", {-4, 5, 1.5}, {12, -4, -2}, 14},
    {"mouthFunnel", "zygomaticus_upper", {-2.5, 1, -0.5}, {0, -2, 0}, 14},
    {"mouthFunnel", "orbicularis", {-0.5, 0, -0.5}, {0, -2, 0}, 14},
    {"mouthFunnel", "mentalis", {-0.5, 0, 0}, {10, -6, 0}, 14},
    {"mouthLeft", "zygomaticus_lower_L", {18.5, -16.5, -2.5}, {-16, -12, -14}},
    {"mouthLeft", "mentalis", {-9, 8, -5.5}, {-4, 6, 12}, 15},
    {"mouthLeft", "zygomaticus_upper_L", {-8.5, 1, 5.5}, {0, -8, -2}, 14},
    {"mouthLeft", "buccinator_L", {-1, -8, -4}, {-20, 8, -6}, 15},
    {"mouthLeft", "zygomaticus_lower_R", {-4, 1.5, 6.5}, {18, 10, -20}, 15},
    {"mouthLeft", "zygomaticus_upper_R", {-7, 0.5, 3.5}, {-2, 2, -10}, 14},
    {"mouthLeft", "buccinator_R", {1.5, 5.5, 1.5}, {36, 6, -2}, 15},
    {"mouthLeft", "orbicularis_R", {-3.5, 0.5, 2}, {-6, 2, -4}, 14},
    {"mouthLeft", "orbicularis_L", {-1.5, -0.5, 1}, {-2, -4, 2}, 14},
    {"mouthLowerDown", "mentalis", {1, 2.5, -3}, {6, -4, -6}},
    {"mouthLowerDown", "buccinator", {0, 0, 2}, {0, 2, 0}, 14},
    {"mouthPress", "mentalis", {-2.5, -1.5, 4}, {0, 0, 8}, 14},
    {"mouthPress", "buccinator", {-0.5, -2.5, -4}, {-4, -6, -2}},
    {"mouthPress", "zygomaticus_lower", {3, 0, 0}, {4, 0, 2}, 14},
    {"mouthPress", "zygomaticus_upper", {-2.5, 1, 1}, {0, -2, 0}, 14},
    {"mouthPress", "orbicularis", {-0.5, 0.5, 1}, {0, -4, -2}, 14},
    {"mouthPucker", "zygomaticus_lower", {-4.5, 7, -3.5}, {12, -4, 12}},
    {"mouthPucker", "buccinator", {-2, 5.5, -2.5}, {14, -8, -2}, 14},
    {"mouthPucker", "zygomaticus_upper", {-3, 0, 0}, {0, -2, 2}, 14},
    {"mouthPucker", "mentalis", {-2.5, 0, 0}, {-2, 2, 0}, 14},
    {"mouthPucker", "orbicularis", {-0.5, 0, -0.5}, {0, 0, 0}, 14},
    {"mouthRollLower", "buccinator", {-2, 2.5, 0}, {2, -8, -2}},
    {"mouthRollLower", "mentalis", {2.5, 0, 0}, {-2, 26, 0}, 14},
    {"mouthRollUpper", "zygomaticus_lower", {7.5, -2.5, 2}, {4, 28, 0}},
    {"mouthRollUpper", "buccinator", {-2.5, 0.5, -5.5}, {2, -12, 4}, 14},
    {"mouthRollUpper", "zygomaticus_upper", {-0.5, 0, 1}, {0, -2, 0}, 14},
    {"mouthShrugLower", "mentalis", {-12, 0, 0}, {-4, 12, 0}},
    {"mouthShrugLower", "buccinator", {-2, 3.5, -1}, {2, -6, 0}, 14},
    {"mouthShrugLower", "zygomaticus_lower", {-1.5, 0, 1}, {0, -2, 0}, 14},
    {"mouthSmile", "zygomaticus_lower", {24, -22, -5.5}, {-8, -20, -18}, 20, 5},
    {"mouthSmile", "buccinator", {-1, -11.5, -10.5}, {-20, -2, 0}, 15},
    {"mouthSmile", "zygomaticus_upper", {-8, -2, 8.5}, {4, -4, -4}, 14},
    {"mouthSmile", "orbicularis", {-8, 0.5, 7.5}, {2, -16, 0}, 14},
    {"mouthSmile", "mentalis", {-3, -1, 3}, {4, 2, 6}, 14},
    {"mouthStretch", "buccinator", {6, -17, 1.5}, {-18, -2, 8}},
    {"mouthStretch", "zygomaticus_lower", {10, -10.5, 5}, {-14, 12, -6}, 14},
    {"mouthStretch", "zygomaticus_upper", {-2.5, 0, 2}, {0, -2, 0}, 14},
    {"mouthStretch", "mentalis", {-1, 0, 1}, {2, 6, 2}, 14},
    {"mouthStretch", "orbicularis", {-0.5, 0, 0.5}, {0, -2, 0}, 14},
    {"mouthUpperUp", "zygomaticus_lower", {6.5, -24.5, -13.5}, {-18, -6, -12}, 20, 5},
    {"mouthUpperUp", "zygomaticus_upper", {-10, 3.5, 2.5}, {0, -10, -2}, 14},
    {"mouthUpperUp", "buccinator", {-2.5, -3.5, -3}, {-6, 8, -4}, 14},
    {"mouthUpperUp", "orbicularis", {-2.5, 0.5, 1}, {0, -8, 0}, 14},
    {"noseSneer", "zygomaticus_lower", {4, -13, -5.5}, {-12, 6, -12}, 20, 4},
    {"noseSneer", "zygomaticus_upper", {-12.5, 1.5, -3.5}, {4, -16, 2}, 14},
    {"noseSneer", "orbicularis", {-8.5, 1, 1.5}, {-2, -22, 6}, 14},
    {"noseSneer", "buccinator", {-3, -3, 0.5}, {-8, 14, -4}, 14},
    {"noseSneer", "frontalis", {2, -1, -0.5}, {-2, 6, 2}, 14},
    {"noseSneer", "mentalis", {-0.5, 0, 0.5}, {0, 0, 0}, 14},
};

/// What `shape` (without side; its left one, if it has sides) does to the skin at this site.
SkinChange change_wanted(std::string_view shape, std::string_view site, bool one_sided) {
  const bool right = site.ends_with("_R");
  for (const SkinChange& change : kSkin) {
    if (change.shape != shape) continue;
    if (change.site == site) return change;
    if (!site.starts_with(change.site) || site.size() != change.site.size() + 2) continue;
    if (!right) return change;
    if (one_sided) continue;
    SkinChange mirrored = change;  // In the mirror a turn about x keeps its sign, about y and z it changes.
    mirrored.turn_deg.y() *= -1;
    mirrored.turn_deg.z() *= -1;
    mirrored.stretch_percent.z() *= -1;
    return mirrored;
  }
  return {.shape = shape,
          .site = site,
          .turn_deg = Vec3::Zero(),
          .stretch_percent = Vec3::Zero(),
          .reach_mm = 14};
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
