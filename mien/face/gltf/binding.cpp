#include "mien/face/gltf/binding.h"

#include <set>
#include <string>

#include "mien/face/target_names.h"

namespace mien::face::gltf {
namespace {

std::vector<std::string> target_names(const tinygltf::Mesh& mesh) {
  const auto from = [](const tinygltf::Value& extras) {
    std::vector<std::string> names;
    if (!extras.IsObject() || !extras.Has("targetNames")) return names;
    const tinygltf::Value& list = extras.Get("targetNames");
    for (std::size_t i = 0; list.IsArray() && i < list.ArrayLen(); ++i) {
      const tinygltf::Value& name = list.Get(static_cast<int>(i));
      names.push_back(name.IsString() ? name.Get<std::string>() : std::string());
    }
    return names;
  };
  auto names = from(mesh.extras);
  if (names.empty() && !mesh.primitives.empty()) names = from(mesh.primitives[0].extras);
  return names;
}

}  // namespace

void Binding::add(std::size_t k, Bind bind) {
  if (++count > kMaxBinds) return;
  binds[k].push_back(bind);
}

std::array<bool, kShapeCount + 1> Binding::taken() const {
  std::array<bool, kShapeCount + 1> taken{};
  for (std::size_t k = 0; k <= kShapeCount; ++k) taken[k] = !binds[k].empty();
  return taken;
}

Binding bind_shapes(const tinygltf::Model& model) {
  Binding binding;
  // A side's own target comes before half of one in one piece.
  for (const bool pairs : {false, true}) {
    const auto taken = binding.taken();
    for (std::size_t m = 0; m < model.meshes.size(); ++m) {
      const auto names = target_names(model.meshes[m]);
      std::set<std::size_t> in_mesh;
      for (std::size_t t = 0; t < names.size(); ++t) {
        const auto shapes = shapes_of_name(names[t]);
        if ((shapes.size() > 1) != pairs) continue;
        for (const std::size_t k : shapes) {
          // Of targets with the same name the first counts.
          if (taken[k] || !in_mesh.insert(k).second) continue;
          binding.add(k, {static_cast<int>(m), t, 1.0});
          binding.split[k] = pairs;
        }
      }
    }
  }
  bind_vrm_expressions(model, binding);
  return binding;
}

}  // namespace mien::face::gltf
