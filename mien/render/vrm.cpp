#include "mien/render/vrm.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/face/profile.h"

namespace mien::render {
namespace {

using nlohmann::json;

struct Bone {
  std::string_view name;
  std::string_view parent;  // Empty: the root.
  std::array<float, 3> place_m;
};

/// Joints of somebody of 1.7 m; parents come first.
constexpr Bone kBones[] = {
    {"hips", "", {0, 0.94F, 0}},
    {"spine", "hips", {0, 1.05F, 0}},
    {"chest", "spine", {0, 1.2F, 0}},
    {"neck", "chest", {0, 1.45F, 0}},
    {"leftUpperArm", "chest", {0.17F, 1.4F, 0}},
    {"leftLowerArm", "leftUpperArm", {0.44F, 1.4F, 0}},
    {"leftHand", "leftLowerArm", {0.68F, 1.4F, 0}},
    {"rightUpperArm", "chest", {-0.17F, 1.4F, 0}},
    {"rightLowerArm", "rightUpperArm", {-0.44F, 1.4F, 0}},
    {"rightHand", "rightLowerArm", {-0.68F, 1.4F, 0}},
    {"leftUpperLeg", "hips", {0.09F, 0.9F, 0}},
    {"leftLowerLeg", "leftUpperLeg", {0.09F, 0.49F, 0}},
    {"leftFoot", "leftLowerLeg", {0.09F, 0.08F, 0}},
    {"rightUpperLeg", "hips", {-0.09F, 0.9F, 0}},
    {"rightLowerLeg", "rightUpperLeg", {-0.09F, 0.49F, 0}},
    {"rightFoot", "rightLowerLeg", {-0.09F, 0.08F, 0}},
};

const Vec3f kHead_m{0, 1.58F, 0};

/// A preset of VRM as ARKit's shapes; a name without its side moves both. Chosen by eye on the built-in face.
struct Preset {
  std::string_view name;
  std::vector<std::pair<std::string_view, double>> shapes;
  bool closes_lids = false;
};

const std::vector<Preset>& presets() {
  static const std::vector<Preset> all = {
      {"aa", {{"jawOpen", 0.6}, {"mouthLowerDown", 0.2}, {"mouthUpperUp", 0.1}}},
      {"ih", {{"jawOpen", 0.2}, {"mouthStretch", 0.3}, {"mouthSmile", 0.2}}},
      {"ou", {{"jawOpen", 0.2}, {"mouthPucker", 0.7}, {"mouthFunnel", 0.3}}},
      {"ee", {{"jawOpen", 0.25}, {"mouthSmile", 0.35}, {"mouthStretch", 0.25}, {"mouthLowerDown", 0.2}}},
      {"oh", {{"jawOpen", 0.4}, {"mouthFunnel", 0.6}, {"mouthPucker", 0.2}}},
      {"blink", {{"eyeBlink", 1}}},
      {"blinkLeft", {{"eyeBlinkLeft", 1}}},
      {"blinkRight", {{"eyeBlinkRight", 1}}},
      {"happy", {{"mouthSmile", 0.85}, {"cheekSquint", 0.6}, {"eyeSquint", 0.3}}},
      {"angry",
       {{"browDown", 0.9}, {"eyeSquint", 0.3}, {"noseSneer", 0.5}, {"mouthPress", 0.5}, {"mouthFrown", 0.3}}},
      {"sad", {{"browInnerUp", 0.8}, {"mouthFrown", 0.7}, {"mouthShrugLower", 0.3}}},
      {"relaxed", {{"mouthSmile", 0.3}, {"eyeBlink", 0.25}}, true},
      {"surprised", {{"browInnerUp", 0.8}, {"browOuterUp", 0.8}, {"eyeWide", 0.7}, {"jawOpen", 0.35}}},
      {"lookUp", {{"eyeLookUp", 1}}},
      {"lookDown", {{"eyeLookDown", 1}}},
      {"lookLeft", {{"eyeLookOutLeft", 1}, {"eyeLookInRight", 1}}},
      {"lookRight", {{"eyeLookInLeft", 1}, {"eyeLookOutRight", 1}}},
  };
  return all;
}

json bind(std::size_t mesh, std::size_t target, double weight) {
  return {{"node", mesh}, {"index", target}, {"weight", weight}};
}

}  // namespace

Result<Vec3f> head_origin_m(const face::Face& face) {
  Eigen::AlignedBox3f box;
  for (const Vec3f& vertex : face.neutral_m) box.extend(vertex);
  if (box.sizes().maxCoeff() > kLargestHead_m)
    return fail(ErrorCode::bad_usage, "it is more than a head, and would hang on the head's bone whole",
                face.name, "give a face without a body, or leave --names vrm out");
  if (face.origin != face::Origin::other) return Vec3f(Vec3f::Zero());
  return Vec3f(box.center());
}

Skeleton add_skeleton(json& nodes, std::size_t head, const std::array<std::optional<std::size_t>, 2>& eyes) {
  Skeleton out;
  const auto add = [&](std::string_view name) {
    nodes.push_back({{"name", name}});
    return nodes.size() - 1;
  };
  json bones = json::object();
  const auto place = [&](std::size_t node, std::string_view parent, const Vec3f& at_m) {
    Vec3f from_m = Vec3f::Zero();
    for (const Bone& bone : kBones)
      if (bone.name == parent) from_m = Vec3f(bone.place_m[0], bone.place_m[1], bone.place_m[2]);
    const Vec3f by_m = at_m - from_m;
    if (node == head) out.head_m = by_m;
    nodes[node]["translation"] = {by_m.x(), by_m.y(), by_m.z()};
    json& owner = nodes[parent.empty() ? out.root : bones[std::string(parent)]["node"].get<std::size_t>()];
    owner["children"].push_back(node);
  };
  out.root = add("avatar");
  for (const Bone& bone : kBones) {
    const std::size_t node = add(bone.name);
    bones[std::string(bone.name)] = {{"node", node}};
    place(node, bone.parent, Vec3f(bone.place_m[0], bone.place_m[1], bone.place_m[2]));
  }
  place(head, "neck", kHead_m);
  bones["head"] = {{"node", head}};
  if (eyes[0]) bones["leftEye"] = {{"node", *eyes[0]}};
  if (eyes[1]) bones["rightEye"] = {{"node", *eyes[1]}};
  out.humanoid = {{"humanBones", std::move(bones)}};
  return out;
}

json vrm_extension(const face::Face& face, const Vec3f& origin_m, std::span<const face::MorphTarget> targets,
                   std::size_t mesh, bool eyes_turn, json humanoid) {
  const auto index = [&](std::string_view name) {
    const auto found = std::ranges::find(targets, name, &face::MorphTarget::name);
    return static_cast<std::size_t>(found - targets.begin());
  };
  json preset = json::object(), custom = json::object();
  for (const Preset& one : presets()) {
    json binds = json::array();
    for (const auto& [shape, weight] : one.shapes) {
      const std::string name(shape);
      for (const std::string& side : {name, name + "Left", name + "Right"})
        if (const std::size_t k = index(side); k < targets.size()) binds.push_back(bind(mesh, k, weight));
    }
    preset[std::string(one.name)] = {{"morphTargetBinds", std::move(binds)}};
    if (one.closes_lids) preset[std::string(one.name)]["overrideBlink"] = "blend";
  }
  preset["neutral"] = json::object();
  for (std::size_t k = 0; k < targets.size(); ++k) {
    std::string name = targets[k].name;
    name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
    custom[name] = {{"morphTargetBinds", json::array({bind(mesh, k, 1)})}};
  }

  // As far as the eyes turn at weight 1, degree for degree.
  const double reach_deg = face::kEyeTurnRadPerUnit * 180 / std::numbers::pi;
  const json range = {{"inputMaxValue", reach_deg}, {"outputScale", eyes_turn ? reach_deg : 1.0}};
  json look = {{"type", eyes_turn ? "bone" : "expression"}};
  if (face.eyes[0].vertex_count > 0 && face.eyes[1].vertex_count > 0) {
    const Vec3f between_m = 0.5F * (face.eyes[0].centre_m + face.eyes[1].centre_m) - origin_m;
    look["offsetFromHeadBone"] = {between_m.x(), between_m.y(), between_m.z()};
  }
  for (const char* map :
       {"rangeMapHorizontalInner", "rangeMapHorizontalOuter", "rangeMapVerticalDown", "rangeMapVerticalUp"})
    look[map] = range;

  json meta = {{"name", face.name.empty() ? "face" : face.name},
               {"version", "1"},
               {"authors", {"unknown"}},
               {"licenseUrl", "https://vrm.dev/licenses/1.0/"}};
  if (face.origin == face::Origin::builtin) {
    meta["authors"] = {"Mien"};
    meta["copyrightInformation"] = "Copyright (c) 2026 The Mien authors, MIT License";
    meta["avatarPermission"] = "everyone";
    meta["commercialUsage"] = "corporation";
    meta["creditNotation"] = "unnecessary";
    meta["allowRedistribution"] = true;
    meta["modification"] = "allowModificationRedistribution";
  }
  return {{"specVersion", "1.0"},
          {"meta", std::move(meta)},
          {"humanoid", std::move(humanoid)},
          {"expressions", {{"preset", std::move(preset)}, {"custom", std::move(custom)}}},
          {"lookAt", std::move(look)}};
}

}  // namespace mien::render
