#include "mien/face/gltf/binding.h"

#include <array>
#include <cmath>
#include <string>

#include "mien/face/gltf/arrays.h"
#include "mien/face/target_names.h"

namespace mien::face::gltf {
namespace {

double number_or(const tinygltf::Value& object, const char* key, double otherwise) {
  if (!object.IsObject() || !object.Has(key)) return otherwise;
  const tinygltf::Value& value = object.Get(key);
  const double number = value.IsNumber() ? value.GetNumberAsDouble() : otherwise;
  return std::isfinite(number) && std::abs(number) <= 1e6 ? number : otherwise;
}

std::string text_or_empty(const tinygltf::Value& object, const char* key) {
  if (!object.IsObject() || !object.Has(key) || !object.Get(key).IsString()) return {};
  return object.Get(key).Get<std::string>();
}

void bind_clip(Binding& binding, const std::string& clip, const tinygltf::Value& binds, double weight_unit,
               const tinygltf::Model& model, const std::array<bool, kShapeCount + 1>& taken) {
  if (!binds.IsArray()) return;
  const auto shapes = shapes_of_name(clip);
  for (std::size_t i = 0; i < binds.ArrayLen(); ++i) {
    const tinygltf::Value& bind = binds.Get(static_cast<int>(i));
    int mesh = static_cast<int>(number_or(bind, "mesh", -1));
    if (const tinygltf::Node* node = at(model.nodes, static_cast<int>(number_or(bind, "node", -1))))
      mesh = node->mesh;
    const double target = number_or(bind, "index", -1);
    const double weight = number_or(bind, "weight", 0) / weight_unit;
    if (mesh < 0 || target < 0 || weight == 0 || std::abs(weight) > 10) continue;
    for (const std::size_t k : shapes) {
      if (taken[k]) continue;
      binding.add(k, {mesh, static_cast<std::size_t>(target), weight});
      binding.split[k] = shapes.size() > 1;
    }
  }
}

}  // namespace

void bind_vrm_expressions(const tinygltf::Model& model, Binding& binding) {
  const auto taken = binding.taken();
  // VRM 0: extensions.VRM.blendShapeMaster.blendShapeGroups[].{name, binds[].{mesh, index, weight}}, weights
  // in percent.
  if (const auto vrm = model.extensions.find("VRM");
      vrm != model.extensions.end() && vrm->second.IsObject()) {
    const tinygltf::Value& master = vrm->second.Get("blendShapeMaster");
    const tinygltf::Value groups = master.IsObject() ? master.Get("blendShapeGroups") : tinygltf::Value();
    for (std::size_t i = 0; groups.IsArray() && i < groups.ArrayLen(); ++i) {
      const tinygltf::Value& group = groups.Get(static_cast<int>(i));
      if (group.IsObject())
        bind_clip(binding, text_or_empty(group, "name"), group.Get("binds"), 100, model, taken);
    }
  }
  // VRM 1: extensions.VRMC_vrm.expressions.custom.<name>.morphTargetBinds[].{node, index, weight}.
  if (const auto vrm = model.extensions.find("VRMC_vrm");
      vrm != model.extensions.end() && vrm->second.IsObject()) {
    const tinygltf::Value& expressions = vrm->second.Get("expressions");
    const tinygltf::Value custom = expressions.IsObject() ? expressions.Get("custom") : tinygltf::Value();
    if (custom.IsObject())
      for (const std::string& key : custom.Keys())
        if (const tinygltf::Value& clip = custom.Get(key); clip.IsObject())
          bind_clip(binding, key, clip.Get("morphTargetBinds"), 1, model, taken);
  }
}

}  // namespace mien::face::gltf
