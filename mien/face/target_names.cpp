#include "mien/face/target_names.h"

#include <functional>
#include <map>
#include <string>

#include "mien/face/gltf/names.h"
#include "mien/face/profile.h"

namespace mien::face {
namespace {

const std::map<std::string, std::vector<std::size_t>, std::less<>>& name_table() {
  static const auto table = [] {
    std::map<std::string, std::vector<std::size_t>, std::less<>> t;
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      const std::string_view shape_name = kShapeNames[k];
      t[gltf::plain(shape_name)] = {k};
      if (!shape_name.ends_with("_L") && !shape_name.ends_with("_R")) continue;
      const std::string stem(shape_name.substr(0, shape_name.size() - 2));
      t[gltf::plain(stem + (shape_name.ends_with("_L") ? "Left" : "Right"))] = {k};
    }
    t["browinnerup"] = {shape("browInnerUp_L"), shape("browInnerUp_R")};
    t["cheekpuff"] = {shape("cheekPuff_L"), shape("cheekPuff_R")};
    t["tongueout"] = {kShapeCount};
    return t;
  }();
  return table;
}

}  // namespace

std::vector<std::size_t> shapes_of_name(std::string_view name) {
  // "Face.eyeBlink_L", "mesh:eyeBlink_L": exporters put the owner in front.
  if (const std::size_t dot = name.find_last_of(".:|"); dot != std::string_view::npos)
    name = name.substr(dot + 1);
  const auto& table = name_table();
  const auto found = table.find(gltf::plain(name));
  return found == table.end() ? std::vector<std::size_t>{} : found->second;
}

std::vector<std::size_t> shapes_named(std::string_view name) {
  if (const std::size_t one = shape_index(name); one < kShapeCount) return {one};
  const std::size_t left = shape_index(std::string(name) + "_L");
  const std::size_t right = shape_index(std::string(name) + "_R");
  if (left < kShapeCount && right < kShapeCount) return {left, right};
  return {};
}

}  // namespace mien::face
