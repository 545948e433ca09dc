#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "mien/face/builtin.h"
#include "mien/face/builtin_anatomy.h"
#include "mien/face/builtin_expression.h"
#include "mien/face/profile.h"

namespace mien::face::builtin {
namespace {

/// What real skin does: the turn of the patch under a sensor, degrees a unit of weight (rotation vector,
/// frame H), by shape without side. The first line of a shape is its best site of the default rig, as
/// measured on the ICT model; the further ones say how the skin around goes along, to a few degrees
/// (docs/builtin_face.md has the source). A site with a side belongs to it alone; one without stands for the
/// left, and for the right as its mirror image where the shape has no side.
struct Turn {
  std::string_view shape, site;
  double deg;            ///< How far.
  Vec3 axis;             ///< About what; of any length.
  double reach_mm = 17;  ///< How far the added turn reaches.
  double swell_mm =
      0;  ///< Pivot this far below the skin's own middle, so that the turned skin swells outward.
};
const Turn kTurns[] = {
    {"browDown", "frontalis", 9.2, {1, -5, -7}},
    {"browInnerUp", "frontalis", 5.0, {0, 1, -4}},
    {"browOuterUp", "frontalis", 9.7, {6, 2, 2}},
    {"cheekPuff", "zygomaticus_lower", 12.7, {-12, -2, 4}},
    {"cheekPuff", "zygomaticus_upper", 13, {-12, -2, 6}, 15},
    {"cheekPuff", "buccinator", 4, {0, -4, -1}, 14},
    {"cheekSquint", "zygomaticus_lower", 11.0, {7, -7, 3}, 20, 5},
    {"cheekSquint", "zygomaticus_upper", 7, {-3, -1, 6}, 14},
    {"cheekSquint", "orbicularis", 3, {-3, -1, 1}, 14},
    {"cheekSquint", "buccinator", 5, {2, -5, 2}, 14},
    {"eyeBlink", "orbicularis", 2.6, {-1, -0.5, -0.5}},
    {"eyeLookDown", "orbicularis", 3.8, {1, 0.5, 0}},
    {"eyeLookIn", "orbicularis", 3.3, {0, -1, 0.5}},
    {"eyeLookOut", "orbicularis", 4.5, {-3, -2, 1}},
    {"eyeLookUp", "orbicularis", 2.0, {-1, -0.3, 0}},
    {"eyeSquint", "orbicularis", 3.7, {0, -1, -4}},
    {"eyeWide", "orbicularis", 0.7, {1, 0, 0}},
    {"jawForward", "buccinator", 11.4, {-9, 0, 7}},
    {"jawForward", "zygomaticus_lower", 8, {-8, 0, 3}, 15},
    {"jawForward", "zygomaticus_upper", 0, {1, 0, 0}, 14},
    {"jawLeft", "buccinator_L", 9.2, {-3, 2, 8}},
    {"jawLeft", "buccinator_R", 6.5, {1, 2, 6}},
    {"jawLeft", "zygomaticus_lower_L", 5, {-1, 3, 4}, 14},
    {"jawLeft", "zygomaticus_lower_R", 3.5, {1, 1, 3}, 14},
    {"jawOpen", "zygomaticus_lower", 17.6, {15, 8, -6}, 20},
    {"jawOpen", "buccinator", 16, {16, -2, 3}, 16},
    {"jawOpen", "zygomaticus_upper", 6, {5, 0, -3}, 15},
    {"jawOpen", "orbicularis", 1, {1, 0, -1}, 14},
    {"jawOpen", "mentalis", 6, {1, 0, 0}, 15},
    {"mouthClose", "buccinator", 22.6, {-19, 11, -3}},
    {"mouthClose", "zygomaticus_lower", 20, {-17, -1, 9}, 16},
    {"mouthClose", "zygomaticus_upper", 0, {1, 0, 0}, 14},
    {"mouthClose", "mentalis", 3, {1, 0, 0}, 15},
    {"mouthDimple", "buccinator", 30.6, {5, -25, -16}},
    {"mouthDimple", "zygomaticus_lower", 28, {19, -20, -6}, 15},
    {"mouthDimple", "zygomaticus_upper", 12, {-11, 2, 4}, 14},
    {"mouthDimple", "mentalis", 6, {-6, 0, 1}, 14},
    {"mouthFrown", "buccinator", 12.1, {0, -8, 8}},
    {"mouthFrown", "zygomaticus_lower", 10, {6, -7, 4}, 14},
    {"mouthFunnel", "zygomaticus_lower", 7.0, {-3, 6, -3}},
    {"mouthFunnel", "buccinator", 6, {-4, 5, 1}, 14},
    {"mouthLeft", "zygomaticus_lower_L", 25.4, {18, -16, -2}},
    {"mouthLeft", "zygomaticus_lower_R", 8, {-4, 2, 7}, 15},
    {"mouthLeft", "zygomaticus_upper_L", 10, {-9, 1, 5}, 14},
    {"mouthLeft", "zygomaticus_upper_R", 8, {-7, 0, 3}, 14},
    {"mouthLeft", "buccinator_L", 9, {-1, -8, -4}, 15},
    {"mouthLeft", "buccinator_R", 6, {2, 5, 1}, 15},
    {"mouthLeft", "mentalis", 13, {-9, 8, -6}, 15},
    {"mouthLowerDown", "mentalis", 3.5, {1, 2, -3}},
    {"mouthPress", "buccinator", 4.7, {-1, -2, -4}},
    {"mouthPress", "mentalis", 5, {-3, -2, 4}, 14},
    {"mouthPucker", "zygomaticus_lower", 9.3, {-5, 7, -4}},
    {"mouthPucker", "buccinator", 6, {-2, 5, -2}, 14},
    {"mouthRollLower", "buccinator", 3.0, {0, -1, 0.3}},
    {"mouthRollUpper", "zygomaticus_lower", 8.1, {8, -3, 2}},
    {"mouthRollUpper", "buccinator", 6, {-2, 0, -6}, 14},
    {"mouthShrugLower", "mentalis", 12.2, {-1, 0, 0}},
    {"mouthShrugLower", "buccinator", 4, {-2, 3, -1}, 14},
    {"mouthSmile", "zygomaticus_lower", 33.7, {24, -22, -5}, 20, 5},
    {"mouthSmile", "zygomaticus_upper", 12, {-8, -2, 9}, 14},
    {"mouthSmile", "orbicularis", 11, {-8, 0, 7}, 14},
    {"mouthSmile", "buccinator", 15, {0, -11, -10}, 15},
    {"mouthSmile", "mentalis", 4, {-3, -1, 3}, 14},
    {"mouthStretch", "buccinator", 18.1, {6, -17, 2}},
    {"mouthStretch", "zygomaticus_lower", 16, {10, -11, 5}, 14},
    {"mouthUpperUp", "zygomaticus_lower", 30.0, {7, -24, -13}, 20, 5},
    {"mouthUpperUp", "zygomaticus_upper", 11, {-10, 4, 2}, 14},
    {"mouthUpperUp", "buccinator", 5, {-3, -4, -3}, 14},
    {"noseSneer", "zygomaticus_lower", 15.3, {4, -13, -5}, 20, 4},
    {"noseSneer", "zygomaticus_upper", 13, {-12, 1, -3}, 14},
    {"noseSneer", "orbicularis", 9, {-9, 1, 2}, 14},
    {"noseSneer", "buccinator", 4, {-3, -3, 1}, 14},
};

Vec3 patch_normal(const Sculpt& whole, const SkinPatch& patch) {
  Vec3 sum = Vec3::Zero();
  for (const SkinPatch::Point& point : patch.points) {
    const Vec3 &a = whole.vertices[point.corner[0]].p, &b = whole.vertices[point.corner[1]].p,
               &c = whole.vertices[point.corner[2]].p;
    sum += point.area_mm2 * (b - a).cross(c - a).normalized();
  }
  return sum.normalized();
}

/// Adds the small turn `turn_rad` about `pivot` to soft skin around `centre`.
void add_turn(const Sculpt& whole, const Vec3& centre, const Vec3& pivot, const Vec3& turn_rad,
              double reach_mm, std::vector<Vec3>& d) {
  for (std::size_t i = 0; i < d.size(); ++i) {
    const SculptVertex& v = whole.vertices[i];
    const bool soft = v.tissue == Tissue::skin || v.tissue == Tissue::lip || v.tissue == Tissue::mouth ||
                      v.tissue == Tissue::brow;
    if (!soft) continue;
    const double q = (v.anchor - centre).squaredNorm() / (reach_mm * reach_mm);
    if (q >= 1) continue;
    const double w = (1 - q) * (1 - q) * (1 + 2 * q) * (1 - smoothstep(0.3, 0.8, std::abs(v.lid)));
    d[i] += w * turn_rad.cross(v.p - pivot);
  }
}

}  // namespace

SkinPatch skin_patch(const Sculpt& whole, const Vec3& site_mm, double radius_mm) {
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

Vec3 patch_rotation_deg(const Sculpt& whole, const SkinPatch& patch, std::span<const Vec3> displacement) {
  Vec3 mean_from = Vec3::Zero(), mean_to = Vec3::Zero();
  double area = 0;
  std::vector<Vec3> from, to;
  for (const SkinPatch::Point& point : patch.points) {
    Vec3 p = Vec3::Zero(), d = Vec3::Zero();
    for (int k = 0; k < 3; ++k) {
      p += point.weight[k] * whole.vertices[point.corner[static_cast<std::size_t>(k)]].p;
      d += point.weight[k] * displacement[point.corner[static_cast<std::size_t>(k)]];
    }
    from.push_back(p);
    to.push_back(p + d);
    mean_from += point.area_mm2 * p;
    mean_to += point.area_mm2 * (p + d);
    area += point.area_mm2;
  }
  mean_from /= area;
  mean_to /= area;
  Mat3 covariance = Mat3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    covariance += patch.points[i].area_mm2 * (from[i] - mean_from) * (to[i] - mean_to).transpose();
  return log_rotation(fit_rotation(covariance)) * 180 / M_PI;
}

void tune_kinematics(const Sculpt& whole, std::vector<std::vector<Vec3>>& displacements) {
  const auto sites = builtin_sites();
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    std::string_view name = kShapeNames[k];
    if (name.ends_with("_R") || name == "jawRight" || name == "mouthRight") continue;
    const bool one_sided = name.ends_with("_L");
    if (one_sided) name.remove_suffix(2);
    struct Target {
      SkinPatch patch;
      Vec3 centre, outward, wanted_deg;
      const Turn* turn;
    };
    std::vector<Target> targets;
    for (const Turn& turn : kTurns) {
      if (turn.shape != name) continue;
      const bool sided = turn.site.ends_with("_L") || turn.site.ends_with("_R");
      for (const BuiltinSite& site : sites) {
        if (sided ? site.name != turn.site : !site.name.starts_with(turn.site)) continue;
        const bool right = site.name.ends_with("_R");
        if (right && one_sided) continue;
        const Vec3 centre = site.position_m * 1000;
        const SkinPatch patch = skin_patch(whole, centre);
        Vec3 axis = turn.axis.normalized();
        // In the mirror x keeps its sign, y and z change theirs.
        if (right && !sided) axis = Vec3(axis.x(), -axis.y(), -axis.z());
        targets.push_back({patch, centre, patch_normal(whole, patch), turn.deg * axis, &turn});
      }
    }
    auto& d = displacements[k];
    // The turns overlap: sweep over all sites until each has what it should.
    for (int sweep = 0; sweep < 12; ++sweep) {
      double worst_deg = 0;
      for (const Target& target : targets) {
        const Vec3 missing = target.wanted_deg - patch_rotation_deg(whole, target.patch, d);
        worst_deg = std::max(worst_deg, missing.norm());
        if (missing.norm() < 0.05) continue;
        const Vec3 step = 0.8 * missing * M_PI / 180;
        const Vec3 pivot = target.centre + target.turn->swell_mm * target.outward.cross(step.normalized());
        add_turn(whole, target.centre, pivot, step, target.turn->reach_mm, d);
      }
      if (worst_deg < 0.3) break;
    }
  }
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    const std::string_view name = kShapeNames[k];
    std::size_t from = k;
    if (name.ends_with("_R")) from = k - 1;
    if (name == "jawRight") from = shape("jawLeft");
    if (name == "mouthRight") from = shape("mouthLeft");
    if (from == k) continue;
    for (std::size_t i = 0; i < whole.vertices.size(); ++i) {
      const Vec3& v = displacements[from][i];
      displacements[k][whole.mirror[i]] = {-v.x(), v.y(), v.z()};
    }
  }
}

}  // namespace mien::face::builtin
