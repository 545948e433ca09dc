#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/rotation.h"

namespace mien::render {

inline constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
inline constexpr int kVertexData = 34962, kIndexData = 34963;

/// A glTF asset while it grows: JSON and the one buffer that it speaks of.
class GltfAsset {
 public:
  nlohmann::json tree;
  ByteWriter buffer;

  GltfAsset() {
    tree["asset"] = {{"version", "2.0"}, {"generator", "Mien"}};
    for (const char* list : {"accessors", "bufferViews", "materials", "meshes", "nodes"})
      tree[list] = nlohmann::json::array();
  }

  std::size_t add(const char* list, nlohmann::json entry) {
    tree[list].push_back(std::move(entry));
    return tree[list].size() - 1;
  }

  /// A view of `bytes`, which begins at a multiple of four.
  std::size_t view(std::span<const std::byte> bytes, int target) {
    while (buffer.bytes().size() % 4 != 0) buffer.little(std::uint8_t{0});
    nlohmann::json entry = {
        {"buffer", 0}, {"byteOffset", buffer.bytes().size()}, {"byteLength", bytes.size()}};
    if (target != 0) entry["target"] = target;
    buffer.append(bytes);
    return add("bufferViews", std::move(entry));
  }
  template <class T>
  std::size_t view(std::span<const T> values, int target) {
    static_assert(std::endian::native == std::endian::little, "buffers are written as they lie in memory");
    return view(std::as_bytes(values), target);
  }

  static void limits(nlohmann::json& accessor, std::span<const Vec3f> values, bool with_zero) {
    Vec3f low = with_zero || values.empty() ? Vec3f(Vec3f::Zero()) : values[0], high = low;
    for (const Vec3f& v : values) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    accessor["min"] = {low.x(), low.y(), low.z()};
    accessor["max"] = {high.x(), high.y(), high.z()};
  }

  /// An accessor of `values`, which are of this type ("VEC3") in components of that one.
  template <class T>
  std::size_t accessor(std::span<const T> values, int target, int component, const char* type,
                       nlohmann::json more = nlohmann::json::object()) {
    more.update({{"bufferView", view(values, target)},
                 {"componentType", component},
                 {"type", type},
                 {"count", values.size()}});
    return add("accessors", std::move(more));
  }

  std::size_t vectors(std::span<const Vec3f> values, bool with_limits) {
    nlohmann::json more = nlohmann::json::object();
    if (with_limits) limits(more, values, false);
    return accessor(values, kVertexData, kFloat, "VEC3", std::move(more));
  }

  /// Zero but for `values` at `index` (ascending).
  std::size_t sparse_vectors(std::vector<std::uint32_t> index, std::vector<Vec3f> values, std::size_t count) {
    if (index.empty()) {
      // A shape that moves nothing here: said by one vertex that moves by nothing, which every reader takes.
      index.push_back(0);
      values.push_back(Vec3f::Zero());
    }
    nlohmann::json accessor = {{"componentType", kFloat}, {"type", "VEC3"}, {"count", count}};
    limits(accessor, values, true);
    accessor["sparse"] = {
        {"count", index.size()},
        {"indices",
         {{"bufferView", view(std::span<const std::uint32_t>(index), 0)}, {"componentType", kUnsignedInt}}},
        {"values", {{"bufferView", view(std::span<const Vec3f>(values), 0)}}}};
    return add("accessors", std::move(accessor));
  }

  std::size_t texture_coordinates(std::span<const Eigen::Vector2f> values) {
    return accessor(values, kVertexData, kFloat, "VEC2");
  }

  std::size_t tangents(std::span<const Eigen::Vector4f> values) {
    return accessor(values, kVertexData, kFloat, "VEC4");
  }

  /// A texture of a picture file's content of this media type, which repeats sideways.
  std::size_t texture(std::span<const std::byte> content, const char* type) {
    for (const char* list : {"images", "samplers", "textures"})
      if (!tree.contains(list)) tree[list] = nlohmann::json::array();
    constexpr int kRepeat = 10497, kClamp = 33071, kLinear = 9729, kTrilinear = 9987;
    const std::size_t sampler =
        add("samplers",
            {{"wrapS", kRepeat}, {"wrapT", kClamp}, {"magFilter", kLinear}, {"minFilter", kTrilinear}});
    const std::size_t image = add("images", {{"bufferView", view(content, 0)}, {"mimeType", type}});
    return add("textures", {{"sampler", sampler}, {"source", image}});
  }

  std::size_t colours(std::span<const std::array<std::uint16_t, 4>> values) {
    return accessor(values, kVertexData, kUnsignedShort, "VEC4", {{"normalized", true}});
  }

  std::size_t indices(std::span<const std::array<std::uint32_t, 3>> triangles) {
    std::span<const std::uint32_t> corners;
    if (!triangles.empty()) corners = {triangles.data()->data(), 3 * triangles.size()};
    return accessor(corners, kIndexData, kUnsignedInt, "SCALAR");
  }

  /// Numbers of an animation, `width` of them a value.
  std::size_t track(std::span<const float> values, const char* type, std::size_t width, bool with_limits) {
    nlohmann::json accessor = {{"bufferView", view(values, 0)},
                               {"componentType", kFloat},
                               {"type", type},
                               {"count", values.size() / width}};
    if (with_limits) {
      accessor["min"] = {values.front()};
      accessor["max"] = {values.back()};
    }
    return add("accessors", std::move(accessor));
  }
};

}  // namespace mien::render
