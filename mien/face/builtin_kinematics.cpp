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

/// What real skin does, by shape without side: its turn at the best site of the default rig, degrees a unit
/// of weight, on the ICT model (docs/builtin_face.md has the table and its source). `axis` is taken where our
/// muscles' own pull turns the skin too little to tell one; anatomy, not measurement.
struct Turn {
  std::string_view shape, site;
  double deg;
  Vec3 axis;
  double reach_mm = 17;  ///< How far the added turn reaches.
  double swell_mm =
      0;  ///< Pivot this far below the skin's own middle, so that the turned skin swells outward.
};
const Turn kTurns[] = {
    {"browDown", "frontalis", 9.2, {1, -0.5, -0.7}},
    {"browInnerUp", "frontalis", 5.0, {-0.5, 0.4, -0.7}},
    {"browOuterUp", "frontalis", 9.7, {0, 0, 1}},
    {"cheekPuff", "zygomaticus_lower", 12.7, {-0.6, -0.7, 0.3}},
    {"cheekSquint", "zygomaticus_lower", 11.0, {1, -0.3, 0}, 20, 5},
    {"eyeBlink", "orbicularis", 2.6, {-1, -0.5, -0.5}},
    {"eyeLookDown", "orbicularis", 3.8, {1, 0.5, 0}},
    {"eyeLookIn", "orbicularis", 3.3, {0, -1, 0.5}},
    {"eyeLookOut", "orbicularis", 4.5, {0, 1, -0.5}},
    {"eyeLookUp", "orbicularis", 2.0, {-1, -0.3, 0}},
    {"eyeSquint", "orbicularis", 3.7, {-1, 0, -0.5}},
    {"eyeWide", "orbicularis", 0.7, {1, 0, 0}},
    {"jawForward", "buccinator", 11.4, {-1, 0, 0}},
    {"jawLeft", "buccinator", 9.2, {0, 0, 1}},
    {"jawOpen", "zygomaticus_lower", 17.6, {1, 0, 0}, 22},
    {"mouthClose", "buccinator", 22.6, {-1, 0, 0}},
    {"mouthDimple", "buccinator", 30.6, {0, -1, -0.4}},
    {"mouthFrown", "buccinator", 12.1, {0.4, 0.2, 1}},
    {"mouthFunnel", "zygomaticus_lower", 7.0, {-0.6, 0.3, -0.7}},
    {"mouthLeft", "zygomaticus_lower", 25.4, {0.7, -0.4, 0.5}},
    {"mouthLowerDown", "mentalis", 3.5, {1, 0, 0}},
    {"mouthPress", "buccinator", 4.7, {0, -1, 0}},
    {"mouthPucker", "zygomaticus_lower", 9.3, {-0.5, 0.2, -0.9}},
    {"mouthRollLower", "buccinator", 3.0, {0, -1, 0.3}},
    {"mouthRollUpper", "zygomaticus_lower", 8.1, {1, -0.4, 0}},
    {"mouthShrugLower", "mentalis", 12.2, {-1, 0, 0}},
    {"mouthSmile", "zygomaticus_lower", 33.7, {0.8, -0.5, 0}, 22, 5},
    {"mouthStretch", "buccinator", 18.1, {0.2, -0.7, 0.7}},
    {"mouthUpperUp", "zygomaticus_lower", 30.0, {1, -0.3, -0.5}, 20, 5},
    {"noseSneer", "zygomaticus_lower", 15.3, {0.6, -0.2, -0.6}, 20, 4},
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
    if (v.tissue != Tissue::skin && v.tissue != Tissue::brow) continue;
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
    const auto turn = std::ranges::find(kTurns, name, &Turn::shape);
    if (turn == std::end(kTurns)) continue;
    auto& d = displacements[k];
    for (const BuiltinSite& site : sites) {
      if (!site.name.starts_with(turn->site) || (one_sided && site.name.ends_with("_R"))) continue;
      const Vec3 centre = site.position_m * 1000;
      const SkinPatch patch = skin_patch(whole, centre);
      const Vec3 outward = patch_normal(whole, patch);
      Vec3 axis = turn->axis.normalized();
      // On the right side of a two-sided shape the mirrored axis: x keeps its sign, y and z change theirs.
      if (site.name.ends_with("_R")) axis = Vec3(axis.x(), -axis.y(), -axis.z());
      const Vec3 own = patch_rotation_deg(whole, patch, d);
      // The muscles' own axis where they turn the skin enough, ours where they do not.
      const Vec3 wanted = turn->deg * (own.norm() > 0.35 * turn->deg ? own.normalized() : axis);
      for (int i = 0; i < 8; ++i) {
        const Vec3 missing = wanted - patch_rotation_deg(whole, patch, d);
        if (missing.norm() < 0.05) break;
        const Vec3 step = 0.9 * missing * M_PI / 180;
        const Vec3 pivot = centre + turn->swell_mm * outward.cross(step.normalized());
        add_turn(whole, centre, pivot, step, turn->reach_mm, d);
      }
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
