#include "mien/face/morph_targets.h"

#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

#include "mien/core/smoothstep.h"
#include "mien/face/profile_map.h"
#include "mien/face/target_names.h"

namespace mien::face {
namespace {

enum class Side : std::uint8_t { both, left, right };
enum class Lip : std::uint8_t { both, upper, lower };

/// A target of Unified Expressions: a share of a portion of one shape.
struct Portion {
  std::string_view name;
  float share = 1;
  Side side = Side::both;
  Lip lip = Lip::both;
  std::string_view shape = {};  ///< Of lids and gaze; all others' is in the profile's table.
};

/// In the order of Unified Expressions' own reference: eyes, brows, cheeks, jaw, lips, mouth, tongue.
constexpr Portion kUnified[] = {
    {.name = "EyeLookOutRight", .shape = "eyeLookOut_R"},
    {.name = "EyeLookInRight", .shape = "eyeLookIn_R"},
    {.name = "EyeLookUpRight", .shape = "eyeLookUp_R"},
    {.name = "EyeLookDownRight", .shape = "eyeLookDown_R"},
    {.name = "EyeLookOutLeft", .shape = "eyeLookOut_L"},
    {.name = "EyeLookInLeft", .shape = "eyeLookIn_L"},
    {.name = "EyeLookUpLeft", .shape = "eyeLookUp_L"},
    {.name = "EyeLookDownLeft", .shape = "eyeLookDown_L"},
    {.name = "EyeClosedRight", .shape = "eyeBlink_R"},
    {.name = "EyeClosedLeft", .shape = "eyeBlink_L"},
    {"EyeSquintRight"},
    {"EyeSquintLeft"},
    {"EyeWideRight"},
    {"EyeWideLeft"},
    {"BrowPinchRight", 0.25F},
    {"BrowPinchLeft", 0.25F},
    {"BrowLowererRight", 0.75F},
    {"BrowLowererLeft", 0.75F},
    {"BrowInnerUpRight"},
    {"BrowInnerUpLeft"},
    {"BrowOuterUpRight"},
    {"BrowOuterUpLeft"},
    {"CheekSquintRight"},
    {"CheekSquintLeft"},
    {"CheekPuffRight"},
    {"CheekPuffLeft"},
    {"JawOpen"},
    {"JawRight"},
    {"JawLeft"},
    {"JawForward"},
    {"MouthClosed"},
    {"LipSuckUpperRight", 1, Side::right},
    {"LipSuckUpperLeft", 1, Side::left},
    {"LipSuckLowerRight", 1, Side::right},
    {"LipSuckLowerLeft", 1, Side::left},
    {"LipFunnelUpperRight", 1, Side::right, Lip::upper},
    {"LipFunnelUpperLeft", 1, Side::left, Lip::upper},
    {"LipFunnelLowerRight", 1, Side::right, Lip::lower},
    {"LipFunnelLowerLeft", 1, Side::left, Lip::lower},
    {"LipPuckerUpperRight", 1, Side::right, Lip::upper},
    {"LipPuckerUpperLeft", 1, Side::left, Lip::upper},
    {"LipPuckerLowerRight", 1, Side::right, Lip::lower},
    {"LipPuckerLowerLeft", 1, Side::left, Lip::lower},
    {"MouthUpperUpRight"},
    {"MouthUpperUpLeft"},
    {"NoseSneerRight"},
    {"NoseSneerLeft"},
    {"MouthLowerDownRight"},
    {"MouthLowerDownLeft"},
    {"MouthUpperRight", 1, Side::both, Lip::upper},
    {"MouthUpperLeft", 1, Side::both, Lip::upper},
    {"MouthLowerRight", 1, Side::both, Lip::lower},
    {"MouthLowerLeft", 1, Side::both, Lip::lower},
    {"MouthCornerPullRight", 0.8F},
    {"MouthCornerPullLeft", 0.8F},
    {"MouthCornerSlantRight", 0.2F},
    {"MouthCornerSlantLeft", 0.2F},
    {"MouthFrownRight"},
    {"MouthFrownLeft"},
    {"MouthStretchRight"},
    {"MouthStretchLeft"},
    {"MouthDimpleRight"},
    {"MouthDimpleLeft"},
    {"MouthRaiserUpper"},
    {"MouthRaiserLower"},
    {"MouthPressRight"},
    {"MouthPressLeft"},
    {"TongueOut"},
};

constexpr float kMidlineHalfWidth_m = 0.008F;
/// Displacement by jawOpen, of its largest, from which skin begins to be the lower lip's, and is it wholly.
constexpr float kLowerFrom = 0.15F, kLowerTo = 0.5F;

/// Which share of a vertex is left, and which the lower lip's.
class Portions {
 public:
  explicit Portions(const Face& face) : face_(face), lower_(face.neutral_m.size(), 0) {
    if (face.eyes[0].vertex_count > 0 && face.eyes[1].vertex_count > 0)
      middle_x_m_ = 0.5F * (face.eyes[0].centre_m.x() + face.eyes[1].centre_m.x());
    const Shape* const jaw = face.find_shape("jawOpen");
    if (jaw == nullptr) return;
    float largest = 0;
    for (const Vec3f& delta : jaw->delta_m) largest = std::max(largest, delta.norm());
    if (!(largest > 0)) return;
    for (std::size_t i = 0; i < jaw->vertex.size(); ++i)
      lower_[jaw->vertex[i]] = smoothstep(kLowerFrom, kLowerTo, jaw->delta_m[i].norm() / largest);
  }
  [[nodiscard]] float of(const Portion& portion, std::uint32_t vertex) const {
    const float left = smoothstep(middle_x_m_ - kMidlineHalfWidth_m, middle_x_m_ + kMidlineHalfWidth_m,
                                  face_.neutral_m[vertex].x());
    const float lower = lower_[vertex];
    return portion.share *
           (portion.side == Side::both   ? 1
            : portion.side == Side::left ? left
                                         : 1 - left) *
           (portion.lip == Lip::both    ? 1
            : portion.lip == Lip::lower ? lower
                                        : 1 - lower);
  }

 private:
  const Face& face_;
  float middle_x_m_ = 0;  // Between the eyes, where they are known.
  std::vector<float> lower_;
};

/// Index as in Face::shapes of the shape that it is a portion of.
std::size_t shape_of(const Portion& portion) {
  if (!portion.shape.empty()) return inner_index(portion.shape);
  const auto at = std::ranges::find(kUnifiedNames, portion.name) - kUnifiedNames.begin();
  return profile_map(OutsideProfile::unified).outward[static_cast<std::size_t>(at)].front().column;
}

/// None where the face lacks it.
const Shape* shape_at(const Face& face, std::size_t k) {
  return k < face.shapes.size() ? &face.shapes[k] : nullptr;
}

void add(MorphTarget& target, const Shape& shape) {
  if (target.vertex.empty()) {
    target.vertex = shape.vertex;
    target.delta_m = shape.delta_m;
    return;
  }
  std::map<std::uint32_t, Vec3f> moved;
  for (std::size_t i = 0; i < target.vertex.size(); ++i) moved.emplace(target.vertex[i], target.delta_m[i]);
  for (std::size_t i = 0; i < shape.vertex.size(); ++i) {
    const auto [at, is_new] = moved.try_emplace(shape.vertex[i], shape.delta_m[i]);
    if (!is_new) at->second += shape.delta_m[i];
  }
  target.vertex.clear();
  target.delta_m.clear();
  for (const auto& [vertex, delta] : moved) {
    target.vertex.push_back(vertex);
    target.delta_m.push_back(delta);
  }
}

MorphTarget sum_of(const Face& face, std::string name, std::vector<std::size_t> shapes) {
  MorphTarget out{.name = std::move(name), .shapes = std::move(shapes), .vertex = {}, .delta_m = {}};
  for (const std::size_t k : out.shapes)
    if (const Shape* const shape = shape_at(face, k)) add(out, *shape);
  return out;
}

std::vector<MorphTarget> arkit_targets(const Face& face) {
  std::vector<MorphTarget> out;
  for (const std::string& name : arkit52().shapes) out.push_back(sum_of(face, name, shapes_of_name(name)));
  return out;
}

std::vector<MorphTarget> unified_targets(const Face& face) {
  const Portions portions(face);
  std::vector<MorphTarget> out;
  for (const Portion& portion : kUnified) {
    const std::size_t k = shape_of(portion);
    MorphTarget& target = out.emplace_back();
    target.name = portion.name;
    target.shapes = {k};
    const Shape* const shape = shape_at(face, k);
    if (shape == nullptr) continue;
    for (std::size_t i = 0; i < shape->vertex.size(); ++i) {
      const float share = portions.of(portion, shape->vertex[i]);
      if (share <= 0) continue;
      target.vertex.push_back(shape->vertex[i]);
      target.delta_m.push_back(share * shape->delta_m[i]);
    }
  }
  return out;
}

}  // namespace

std::vector<MorphTarget> morph_targets(const Face& face, TargetNames names) {
  switch (names) {
    case TargetNames::arkit:
      return arkit_targets(face);
    case TargetNames::unified:
      return unified_targets(face);
    case TargetNames::ict:
      break;
  }
  std::vector<MorphTarget> out;
  for (std::size_t k = 0; k < face.shapes.size(); ++k) out.push_back(sum_of(face, face.shapes[k].name, {k}));
  return out;
}

float weight_of(const MorphTarget& target, const BlendshapeWeights& weights, float tongue_out) {
  float sum = 0;
  for (const std::size_t k : target.shapes) sum += k < kShapeCount ? weights[k] : tongue_out;
  return sum / static_cast<float>(target.shapes.size());
}

}  // namespace mien::face
