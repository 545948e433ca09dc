#include "mien/face/gltf_import.h"

#include <fmt/format.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "mien/core/bytes.h"
#include "mien/core/files.h"
#include "mien/core/smoothstep.h"

namespace mien::face {
namespace fs = std::filesystem;
namespace {

using Mat4 = Eigen::Matrix4d;

inline constexpr std::size_t kMaxBytes = std::size_t{1} << 30U;
inline constexpr std::size_t kMaxVertices = 4'000'000;
inline constexpr std::size_t kMaxTriangles = 8'000'000;
inline constexpr std::size_t kMaxDeltas = 10'000'000;
inline constexpr std::size_t kMaxBinds = 4096;
inline constexpr std::size_t kMaxJsonDepth = 128;
inline constexpr std::size_t kMaxNodes = 100'000;
inline constexpr std::size_t kMaxNodeDepth = 512;
inline constexpr std::size_t kTongueOutPlace = kShapeCount;

// ---- Names
// ----------------------------------------------------------------------------------------------------------

/// Lower case without separators: "Eye_Blink-Left" becomes "eyeblinkleft".
std::string plain(std::string_view name) {
  std::string out;
  for (const char c : name) {
    if (c >= 'A' && c <= 'Z')
      out += static_cast<char>(c - 'A' + 'a');
    else if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'))
      out += c;
  }
  return out;
}

const std::map<std::string, std::vector<std::size_t>, std::less<>>& name_table() {
  static const auto table = [] {
    std::map<std::string, std::vector<std::size_t>, std::less<>> t;
    for (std::size_t k = 0; k < kShapeCount; ++k) {
      const std::string_view shape_name = kShapeNames[k];
      t[plain(shape_name)] = {k};
      if (!shape_name.ends_with("_L") && !shape_name.ends_with("_R")) continue;
      const std::string stem(shape_name.substr(0, shape_name.size() - 2));
      t[plain(stem + (shape_name.ends_with("_L") ? "Left" : "Right"))] = {k};
    }
    t["browinnerup"] = {shape("browInnerUp_L"), shape("browInnerUp_R")};
    t["cheekpuff"] = {shape("cheekPuff_L"), shape("cheekPuff_R")};
    t["tongueout"] = {kTongueOutPlace};
    return t;
  }();
  return table;
}

std::string_view shape_name(std::size_t k) {
  return k < kShapeCount ? kShapeNames[k] : "tongueOut";
}

bool has_word(std::string_view text, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(words,
                             [&](std::string_view w) { return text.find(w) != std::string_view::npos; });
}

/// What a mesh or its material is called tells what it is made of, well enough to shade it.
Material guess_material(const std::string& names) {
  if (has_word(names, {"brow", "hair", "beard"})) return Material::hair;
  if (has_word(names, {"lash"})) return Material::lash;
  if (has_word(names, {"tongue"})) return Material::tongue;
  if (has_word(names, {"gum"})) return Material::gums;
  if (has_word(names, {"teeth", "tooth"})) return Material::teeth;
  if (has_word(names, {"cornea", "occlusion", "tearline", "lacrimal"})) return Material::cornea;
  if (has_word(names, {"iris"})) return Material::iris;
  if (has_word(names, {"pupil"})) return Material::pupil;
  if (has_word(names, {"eyeline"})) return Material::lash;
  if (has_word(names, {"eye", "sclera"})) return Material::sclera;
  if (has_word(names, {"mouth", "oral"})) return Material::mouth_inside;
  if (has_word(names, {"cloth", "shirt", "accessor", "glasses"})) return Material::other;
  return Material::skin;
}

/// A name from the file on one line, without anything that a terminal would obey.
std::string printable(std::string name) {
  if (name.size() > 80) name.resize(80);
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return name;
}

// ---- Reading the container
// -------------------------------------------------------------------------------------------

/// tinygltf walks JSON recursively: text that nests deeper than any real file must not reach it.
bool nests_too_deep(std::string_view json) {
  std::size_t depth = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (quoted) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      if (++depth > kMaxJsonDepth) return true;
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return false;
}

/// What tinygltf may read from the disk: plain files in the glTF's own folder and beneath it.
struct Folder {
  fs::path path;  // Empty: nothing at all.

  [[nodiscard]] bool holds(const std::string& file) const {
    if (path.empty()) return false;
    std::error_code code;
    const fs::path real = fs::weakly_canonical(file, code);
    if (code || !fs::is_regular_file(real, code)) return false;
    const fs::path relative = real.lexically_relative(path);
    return !relative.empty() && *relative.begin() != "..";
  }
};

tinygltf::FsCallbacks callbacks(Folder& folder) {
  tinygltf::FsCallbacks c{};
  c.FileExists = [](const std::string& file, void* data) { return static_cast<Folder*>(data)->holds(file); };
  c.ExpandFilePath = [](const std::string& file, void*) { return file; };
  c.ReadWholeFile = [](std::vector<unsigned char>* out, std::string* error, const std::string& file,
                       void* data) {
    if (!static_cast<Folder*>(data)->holds(file)) {
      if (error != nullptr) *error += fmt::format("{} is not in the folder of the glTF", file);
      return false;
    }
    const auto bytes = read_file(file, kMaxBytes);
    if (!bytes || bytes->empty()) return false;
    out->resize(bytes->size());
    std::memcpy(out->data(), bytes->data(), bytes->size());
    return true;
  };
  c.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
    return false;
  };
  c.user_data = &folder;
  return c;
}

std::string first_line(std::string text) {
  const std::size_t end = text.find_first_of("\r\n");
  if (end != std::string::npos) text.resize(end);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) >= 0x7F) c = '?';
  if (text.size() > 160) text = text.substr(0, 157) + "...";
  while (!text.empty() && (text.back() == '.' || text.back() == ' ')) text.pop_back();
  return text;
}

Result<tinygltf::Model> read_container(std::span<const std::byte> bytes, const std::string& name,
                                       Folder& folder) {
  if (bytes.empty()) return fail(ErrorCode::truncated, "the file is empty", name);
  if (bytes.size() > kMaxBytes) return fail(ErrorCode::out_of_range, "the file is larger than 1 GiB", name);
  const bool binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
  std::string_view json(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (binary) {
    ByteReader header(bytes.subspan(4));
    const auto version = header.little<std::uint32_t>();
    const auto length = header.little<std::uint32_t>();
    const auto json_length = header.little<std::uint32_t>();
    const auto kind = header.take(4);
    const auto chunk = header.take(json_length);
    if (!header.ok() || length > bytes.size())
      return fail(ErrorCode::truncated, "the file is cut short", name);
    if (version != 2)
      return fail(ErrorCode::unsupported, fmt::format("this is glTF version {}, not 2", version), name);
    if (std::memcmp(kind.data(), "JSON", 4) != 0)
      return fail(ErrorCode::malformed, "the first chunk is not JSON", name);
    json = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
  }
  if (nests_too_deep(json))
    return fail(ErrorCode::malformed, "the JSON nests deeper than any glTF does", name);

  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(callbacks(folder));
  // Pictures are nothing to us; unread, they cannot grow in memory either.
  loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                           const unsigned char*, int, void*) { return true; },
                        nullptr);
  tinygltf::Model model;
  std::string error;
  std::string warning;
  bool read = false;
  try {
    const auto size = static_cast<unsigned int>(bytes.size());
    if (binary)
      read = loader.LoadBinaryFromMemory(&model, &error, &warning,
                                         reinterpret_cast<const unsigned char*>(bytes.data()), size,
                                         folder.path.string());
    else
      read = loader.LoadASCIIFromString(&model, &error, &warning, json.data(), size, folder.path.string());
  } catch (const std::exception& thrown) {
    error = thrown.what();
    read = false;
  }
  if (!read)
    return fail(ErrorCode::malformed,
                error.empty() ? "this is no glTF" : "this is no sound glTF: " + first_line(error), name);
  for (const std::string& extension : model.extensionsRequired)
    if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression")
      return fail(ErrorCode::unsupported, fmt::format("its meshes are compressed ({})", extension), name,
                  "export it without compression");
  return model;
}

// ---- Reading accessors
// -----------------------------------------------------------------------------------------------

template <class T>
const T* at(const std::vector<T>& items, int index) {
  return index >= 0 && static_cast<std::size_t>(index) < items.size()
             ? &items[static_cast<std::size_t>(index)]
             : nullptr;
}

/// Reads a model's arrays; every size is held against the bytes that are there.
class Arrays {
 public:
  Arrays(const tinygltf::Model& model, const std::string& name) : model_(model), name_(name) {}

  /// Rows of `width` numbers. `expected` is the number of rows where it is known; without it the rows must
  /// have bytes of their own. Normalised integers become fractions.
  Result<std::vector<double>> read(int index, std::size_t width, std::optional<std::size_t> expected) const {
    const tinygltf::Accessor* accessor = at(model_.accessors, index);
    if (accessor == nullptr) return bad("an accessor that is not there is named");
    const int components = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor->type));
    if (components != static_cast<int>(width))
      return bad(fmt::format("accessor {} has the wrong type", index));
    if (expected && accessor->count != *expected)
      return bad(
          fmt::format("accessor {} has {} elements where {} belong", index, accessor->count, *expected));
    if (!expected && accessor->count > kMaxTriangles * 3)
      return bad(fmt::format("accessor {} is too large", index));
    std::vector<double> values;
    if (accessor->bufferView >= 0) {
      MIEN_TRY_ASSIGN(values, strided(accessor->bufferView, accessor->byteOffset, accessor->componentType,
                                      width, accessor->count, accessor->normalized));
    } else if (expected) {
      values.assign(accessor->count * width, 0.0);
    } else {
      return bad(fmt::format("accessor {} has no data", index));
    }
    if (accessor->sparse.isSparse) {
      const auto& sparse = accessor->sparse;
      if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > accessor->count ||
          sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
        return bad(fmt::format("accessor {} is wrongly sparse", index));
      const auto count = static_cast<std::size_t>(sparse.count);
      MIEN_TRY_ASSIGN(const auto rows,
                      strided(sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                              sparse.indices.componentType, 1, count, false));
      MIEN_TRY_ASSIGN(const auto changed,
                      strided(sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                              accessor->componentType, width, count, accessor->normalized));
      for (std::size_t i = 0; i < count; ++i) {
        if (!(rows[i] >= 0 && rows[i] < static_cast<double>(accessor->count)))
          return bad(fmt::format("accessor {} is wrongly sparse", index));
        std::copy_n(
            changed.begin() + static_cast<std::ptrdiff_t>(i * width), width,
            values.begin() + static_cast<std::ptrdiff_t>(rows[i]) * static_cast<std::ptrdiff_t>(width));
      }
    }
    for (const double v : values)
      if (!(std::abs(v) <= 1e9))
        return fail(ErrorCode::out_of_range, fmt::format("accessor {} holds a number beyond 1e9", index),
                    name_);
    return values;
  }

  [[nodiscard]] std::unexpected<Error> bad(std::string what) const {
    return fail(ErrorCode::malformed, std::move(what), name_);
  }

 private:
  Result<std::vector<double>> strided(int view_index, std::size_t offset, int type, std::size_t width,
                                      std::size_t count, bool normalized) const {
    const tinygltf::BufferView* view = at(model_.bufferViews, view_index);
    if (view == nullptr) return bad("a buffer view that is not there is named");
    const tinygltf::Buffer* buffer = at(model_.buffers, view->buffer);
    if (buffer == nullptr) return bad("a buffer that is not there is named");
    const int size = tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type));
    if (size <= 0) return bad("an accessor has an unknown number format");
    const std::size_t element = static_cast<std::size_t>(size) * width;
    const std::size_t stride = view->byteStride == 0 ? element : view->byteStride;
    const std::size_t have = buffer->data.size();
    // Every difference below is taken only after it is known not to be negative.
    if (view->byteOffset > have || view->byteLength > have - view->byteOffset)
      return fail(ErrorCode::truncated, "a buffer view reaches beyond its buffer", name_);
    if (count > 0 && (offset > view->byteLength || element > view->byteLength - offset ||
                      (count - 1) > (view->byteLength - offset - element) / stride))
      return fail(ErrorCode::truncated, "an accessor reaches beyond its buffer view", name_);
    std::vector<double> values;
    values.reserve(count * width);
    for (std::size_t i = 0; i < count; ++i) {
      const unsigned char* row = buffer->data.data() + view->byteOffset + offset + i * stride;
      for (std::size_t c = 0; c < width; ++c)
        values.push_back(component(row + c * static_cast<std::size_t>(size), type, normalized));
    }
    return values;
  }

  template <class T>
  static double load(const unsigned char* from) {
    ByteReader reader(std::as_bytes(std::span(from, sizeof(T))));
    return static_cast<double>(reader.little<T>());
  }

  static double component(const unsigned char* from, int type, bool normalized) {
    switch (type) {
      case TINYGLTF_COMPONENT_TYPE_BYTE:
        return normalized ? std::max(load<std::int8_t>(from) / 127, -1.0) : load<std::int8_t>(from);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return normalized ? load<std::uint8_t>(from) / 255 : load<std::uint8_t>(from);
      case TINYGLTF_COMPONENT_TYPE_SHORT:
        return normalized ? std::max(load<std::int16_t>(from) / 32767, -1.0) : load<std::int16_t>(from);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return normalized ? load<std::uint16_t>(from) / 65535 : load<std::uint16_t>(from);
      case TINYGLTF_COMPONENT_TYPE_INT:
        return load<std::int32_t>(from);
      case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return load<std::uint32_t>(from);
      case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return load<float>(from);
      default:
        return load<double>(from);
    }
  }

  const tinygltf::Model& model_;
  const std::string& name_;
};

// ---- Nodes
// -----------------------------------------------------------------------------------------------------------

Mat4 local_transform(const tinygltf::Node& node) {
  Mat4 m = Mat4::Identity();
  if (node.matrix.size() == 16) {
    for (int i = 0; i < 16; ++i) m(i % 4, i / 4) = node.matrix[static_cast<std::size_t>(i)];
    return m;
  }
  if (node.rotation.size() == 4) {
    const Quat q(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    if (q.norm() > 1e-9) m.topLeftCorner<3, 3>() = q.normalized().toRotationMatrix();
  }
  if (node.scale.size() == 3)
    m.topLeftCorner<3, 3>() *= Vec3(node.scale[0], node.scale[1], node.scale[2]).asDiagonal();
  if (node.translation.size() == 3)
    m.topRightCorner<3, 1>() = Vec3(node.translation[0], node.translation[1], node.translation[2]);
  return m;
}

/// Every node of the scene once, parents first, and where it stands in the world. A node that is reached
/// twice (which glTF forbids, and which could go round for ever) counts the first time.
struct Placed {
  int node = -1;
  Mat4 world = Mat4::Identity();
};

Result<std::vector<Placed>> place_nodes(const tinygltf::Model& model, const Arrays& arrays) {
  std::vector<int> roots;
  if (const tinygltf::Scene* scene = at(model.scenes, std::max(model.defaultScene, 0)))
    roots = scene->nodes;
  else
    for (std::size_t i = 0; i < model.nodes.size(); ++i) roots.push_back(static_cast<int>(i));
  if (model.nodes.size() > kMaxNodes)
    return arrays.bad(fmt::format("there are more than {} nodes", kMaxNodes));
  std::vector<bool> seen(model.nodes.size());
  std::vector<Placed> placed;
  struct Open {
    int node;
    Mat4 parent;
    std::size_t depth;
  };
  std::vector<Open> open;
  for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.push_back({*root, Mat4::Identity(), 0});
  while (!open.empty()) {
    const Open next = open.back();
    open.pop_back();
    const tinygltf::Node* node = at(model.nodes, next.node);
    if (node == nullptr) return arrays.bad("a node that is not there is named");
    if (next.depth > kMaxNodeDepth) return arrays.bad("the nodes nest too deep");
    if (seen[static_cast<std::size_t>(next.node)]) continue;
    seen[static_cast<std::size_t>(next.node)] = true;
    const Mat4 world = next.parent * local_transform(*node);
    if (!world.allFinite() || world.cwiseAbs().maxCoeff() > 1e9)
      return fail(ErrorCode::out_of_range, "a node's transform is beyond all bounds", printable(node->name));
    placed.push_back({next.node, world});
    for (auto child = node->children.rbegin(); child != node->children.rend(); ++child)
      open.push_back({*child, world, next.depth + 1});
  }
  return placed;
}

// ---- Which target is which shape
// -------------------------------------------------------------------------------------

/// A target of a mesh, and how much of it makes the shape.
struct Bind {
  int mesh = -1;
  std::size_t target = 0;
  double weight = 1;
};

struct Binding {
  std::array<std::vector<Bind>, kShapeCount + 1> binds;
  std::array<bool, kShapeCount + 1> split{};  ///< Half of a shape that the file has in one piece.
  std::size_t count = 0;

  void add(std::size_t k, Bind bind) {
    if (++count > kMaxBinds) return;
    binds[k].push_back(bind);
  }
};

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

Binding bind_shapes(const tinygltf::Model& model) {
  Binding binding;
  // A side's own target comes before half of one in one piece.
  for (const bool pairs : {false, true}) {
    std::array<bool, kShapeCount + 1> taken{};
    for (std::size_t k = 0; k <= kShapeCount; ++k) taken[k] = !binding.binds[k].empty();
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
  std::array<bool, kShapeCount + 1> taken{};
  for (std::size_t k = 0; k <= kShapeCount; ++k) taken[k] = !binding.binds[k].empty();
  // VRM 0: extensions.VRM.blendShapeMaster.blendShapeGroups[].{name, binds[].{mesh, index, weight in
  // percent}}.
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
  return binding;
}

// ---- Putting the head together
// ---------------------------------------------------------------------------------------

/// The head in the file's unit and direction, before it is made a Face.
struct Assembly {
  std::vector<Vec3> position;
  std::vector<Eigen::Vector2f> uv;
  std::vector<Vec3f> colour;
  bool has_uv = true;
  bool has_colour = true;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Part> parts;
  std::array<std::vector<std::pair<std::uint32_t, Vec3>>, kShapeCount + 1> delta;  // Vertices ascending.
  std::size_t delta_count = 0;
  std::vector<bool> skin;  // Beside position.
  struct Eye {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::optional<Vec3> pivot;
  };
  std::vector<Eye> eyes;
};

/// Cuts an index list into triangles as its mode says.
Result<void> add_triangles(const std::vector<double>& index, int mode, std::uint32_t first_vertex,
                           std::size_t vertices, Assembly& out, const Arrays& arrays) {
  for (const double i : index)
    if (!(i >= 0 && i < static_cast<double>(vertices)))
      return arrays.bad("a triangle names a vertex that is not there");
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    const auto vertex = [&](std::size_t i) { return first_vertex + static_cast<std::uint32_t>(index[i]); };
    out.triangles.push_back({vertex(a), vertex(b), vertex(c)});
  };
  if (out.triangles.size() + index.size() > kMaxTriangles) return arrays.bad("there are too many triangles");
  if (mode == TINYGLTF_MODE_TRIANGLES)
    for (std::size_t i = 0; i + 2 < index.size(); i += 3) add(i, i + 1, i + 2);
  else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
    for (std::size_t i = 0; i + 2 < index.size(); ++i) add(i, i + 1 + i % 2, i + 2 - i % 2);
  else
    for (std::size_t i = 1; i + 1 < index.size(); ++i) add(0, i, i + 1);
  return {};
}

/// Each vertex's matrix: its node's, or where it is skinned the mean of its joints' at rest.
Result<std::vector<Mat4>> vertex_matrices(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                                          const tinygltf::Node& node, const Mat4& world,
                                          const std::vector<Mat4>& worlds, std::size_t vertices,
                                          const Arrays& arrays) {
  const tinygltf::Skin* skin = at(model.skins, node.skin);
  const auto joints_at = primitive.attributes.find("JOINTS_0");
  const auto weights_at = primitive.attributes.find("WEIGHTS_0");
  if (skin == nullptr || joints_at == primitive.attributes.end() || weights_at == primitive.attributes.end())
    return std::vector<Mat4>{world};
  std::vector<Mat4> joint(skin->joints.size());
  std::vector<double> inverse;
  if (skin->inverseBindMatrices >= 0) {
    MIEN_TRY_ASSIGN(inverse, arrays.read(skin->inverseBindMatrices, 16, joint.size()));
  }
  for (std::size_t j = 0; j < joint.size(); ++j) {
    if (at(worlds, skin->joints[j]) == nullptr) return arrays.bad("a skin names a joint that is not there");
    joint[j] = *at(worlds, skin->joints[j]);
    if (!inverse.empty()) joint[j] *= Eigen::Map<const Mat4>(inverse.data() + 16 * j);
  }
  MIEN_TRY_ASSIGN(const auto joints, arrays.read(joints_at->second, 4, vertices));
  MIEN_TRY_ASSIGN(const auto weights, arrays.read(weights_at->second, 4, vertices));
  std::vector<Mat4> matrices(vertices, Mat4::Zero());
  for (std::size_t v = 0; v < vertices; ++v) {
    double sum = 0;
    for (std::size_t c = 4 * v; c < 4 * v + 4; ++c) {
      if (weights[c] <= 0) continue;
      if (!(joints[c] >= 0 && joints[c] < static_cast<double>(joint.size())))
        return arrays.bad("a vertex names a joint that is not there");
      matrices[v] += weights[c] * joint[static_cast<std::size_t>(joints[c])];
      sum += weights[c];
    }
    if (sum > 0)
      matrices[v] /= sum;
    else
      matrices[v] = world;
  }
  return matrices;
}

/// A run of vertices in the assembly, and the primitive that brought it.
struct Shared {
  const tinygltf::Primitive* primitive = nullptr;
  std::uint32_t first = 0;
  std::size_t vertices = 0;
  bool bound = false;  ///< Whether a shape is bound to it.
};

/// Adds a primitive's vertices with their shapes.
Result<Shared> add_vertices(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
                            const tinygltf::Node& node, const Placed& placed, const std::vector<Mat4>& worlds,
                            const Binding& binding, Assembly& out, const Arrays& arrays) {
  const auto position_at = primitive.attributes.find("POSITION");
  MIEN_TRY_ASSIGN(const auto position, arrays.read(position_at->second, 3, std::nullopt));
  const std::size_t vertices = position.size() / 3;
  if (out.position.size() + vertices > kMaxVertices)
    return fail(ErrorCode::out_of_range, fmt::format("there are more than {} vertices", kMaxVertices),
                printable(node.name));
  const auto first = static_cast<std::uint32_t>(out.position.size());
  MIEN_TRY_ASSIGN(const auto matrices,
                  vertex_matrices(model, primitive, node, placed.world, worlds, vertices, arrays));
  const auto matrix = [&](std::size_t v) -> const Mat4& { return matrices[matrices.size() == 1 ? 0 : v]; };
  const auto vec = [](const std::vector<double>& values, std::size_t v) {
    return Vec3(values[3 * v], values[3 * v + 1], values[3 * v + 2]);
  };
  for (std::size_t v = 0; v < vertices; ++v) {
    const Vec3 at_v = (matrix(v) * vec(position, v).homogeneous()).head<3>();
    if (!(at_v.cwiseAbs().maxCoeff() <= 1e9))
      return fail(ErrorCode::out_of_range, "a vertex lies beyond all bounds", printable(node.name));
    out.position.push_back(at_v);
  }

  const tinygltf::Material* material = at(model.materials, primitive.material);
  if (const auto uv_at = primitive.attributes.find("TEXCOORD_0");
      out.has_uv && uv_at != primitive.attributes.end()) {
    MIEN_TRY_ASSIGN(const auto uv, arrays.read(uv_at->second, 2, vertices));
    for (std::size_t v = 0; v < vertices; ++v)
      out.uv.emplace_back(static_cast<float>(uv[2 * v]), static_cast<float>(uv[2 * v + 1]));
  } else {
    out.has_uv = false;
  }
  // The factor alone is the colour only where no picture is laid over it.
  if (material != nullptr && material->pbrMetallicRoughness.baseColorTexture.index < 0 &&
      material->pbrMetallicRoughness.baseColorFactor.size() == 4) {
    Vec3f colour;
    for (int c = 0; c < 3; ++c)
      colour[c] = std::clamp(
          static_cast<float>(material->pbrMetallicRoughness.baseColorFactor[static_cast<std::size_t>(c)]),
          0.0F, 1.0F);
    out.colour.insert(out.colour.end(), vertices, colour);
  } else {
    out.has_colour = false;
  }

  bool bound = false;
  for (std::size_t k = 0; k <= kShapeCount; ++k) {
    std::vector<Vec3> moved;
    for (const Bind& bind : binding.binds[k]) {
      if (bind.mesh != node.mesh || bind.target >= primitive.targets.size()) continue;
      const auto target_at = primitive.targets[bind.target].find("POSITION");
      if (target_at == primitive.targets[bind.target].end()) continue;
      MIEN_TRY_ASSIGN(const auto target, arrays.read(target_at->second, 3, vertices));
      moved.resize(vertices, Vec3::Zero());
      for (std::size_t v = 0; v < vertices; ++v)
        moved[v] += matrix(v).topLeftCorner<3, 3>() * vec(target, v) * bind.weight;
    }
    bound = bound || !moved.empty();
    for (std::size_t v = 0; v < moved.size(); ++v) {
      if (!(moved[v].cwiseAbs().maxCoeff() <= 1e9))
        return fail(ErrorCode::out_of_range, "a morph target moves beyond all bounds", printable(node.name));
      if (moved[v].isZero(0)) continue;
      if (++out.delta_count > kMaxDeltas) return arrays.bad("its morph targets move too many vertices");
      out.delta[k].emplace_back(first + static_cast<std::uint32_t>(v), moved[v]);
    }
  }
  out.skin.resize(out.position.size());
  return Shared{&primitive, first, vertices, bound};
}

Result<void> add_mesh(const tinygltf::Model& model, const Placed& placed, const std::vector<Mat4>& worlds,
                      const Binding& binding, Assembly& out, const Arrays& arrays) {
  const tinygltf::Node& node = model.nodes[static_cast<std::size_t>(placed.node)];
  const tinygltf::Mesh* mesh = at(model.meshes, node.mesh);
  if (mesh == nullptr) return arrays.bad("a mesh that is not there is named");
  const auto mesh_first = static_cast<std::uint32_t>(out.position.size());
  bool moves = false;
  // Exporters cut one set of vertices into primitives by material: what is shared in the file stays shared.
  std::vector<Shared> shared;
  for (std::size_t p = 0; p < mesh->primitives.size(); ++p) {
    const tinygltf::Primitive& primitive = mesh->primitives[p];
    const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
    if (mode < TINYGLTF_MODE_TRIANGLES || mode > TINYGLTF_MODE_TRIANGLE_FAN) continue;  // Points and lines.
    if (!primitive.attributes.contains("POSITION")) continue;
    const auto known = std::ranges::find_if(shared, [&](const Shared& one) {
      return one.primitive->attributes == primitive.attributes && one.primitive->targets == primitive.targets;
    });
    Shared mine;
    if (known != shared.end()) {
      mine = *known;
      out.has_colour = false;  // Two materials on one vertex have no one colour.
    } else {
      MIEN_TRY_ASSIGN(mine, add_vertices(model, primitive, node, placed, worlds, binding, out, arrays));
      shared.push_back(mine);
    }

    const auto first_triangle = static_cast<std::uint32_t>(out.triangles.size());
    std::vector<double> index;
    if (primitive.indices >= 0) {
      MIEN_TRY_ASSIGN(index, arrays.read(primitive.indices, 1, std::nullopt));
    } else {
      for (std::size_t v = 0; v < mine.vertices; ++v) index.push_back(static_cast<double>(v));
    }
    MIEN_TRY(add_triangles(index, mode, mine.first, mine.vertices, out, arrays));

    const tinygltf::Material* material = at(model.materials, primitive.material);
    const std::string material_name = material != nullptr ? material->name : std::string();
    const std::string part_name = printable(!mesh->name.empty() ? mesh->name : node.name);
    const Material kind = guess_material(plain(part_name + " " + material_name));
    out.parts.push_back({part_name.empty() ? fmt::format("part_{}", out.parts.size()) : part_name, kind,
                         first_triangle, static_cast<std::uint32_t>(out.triangles.size()) - first_triangle});

    if (mine.bound && kind == Material::skin)
      for (const double i : index) out.skin[mine.first + static_cast<std::size_t>(i)] = true;
    moves = moves || mine.bound;
  }
  const auto mesh_count = static_cast<std::uint32_t>(out.position.size()) - mesh_first;
  const std::string called = plain(mesh->name + " " + node.name);
  if (!moves && mesh_count > 0 && has_word(called, {"eye"}) &&
      !has_word(called, {"lash", "brow", "lid", "occlusion", "line", "shadow"})) {
    // A pivot is believed where it lies inside the eyeball.
    Eigen::AlignedBox3d box;
    for (std::uint32_t v = mesh_first; v < mesh_first + mesh_count; ++v) box.extend(out.position[v]);
    const Vec3 pivot = placed.world.topRightCorner<3, 1>();
    out.eyes.push_back({mesh_first, mesh_count, box.contains(pivot) ? std::optional(pivot) : std::nullopt});
  }
  return {};
}

/// Whether the head looks along -Z: by where the shapes that push forward push, else by where the left ones
/// are.
bool looks_backwards(const Assembly& head, double left_minus_right) {
  double forward = 0;
  double all = 0;
  for (const std::size_t k : {shape("jawForward"), shape("mouthPucker"), shape("mouthFunnel")})
    for (const auto& [vertex, delta] : head.delta[k]) {
      forward += delta.z();
      all += delta.norm();
    }
  if (all > 0 && std::abs(forward) > 0.2 * all) return forward < 0;
  return left_minus_right < 0;
}

/// Mean distance in x between the left shapes' vertices and the right ones': positive where left is on +X.
double left_minus_right(const Assembly& head) {
  double difference = 0;
  for (std::size_t k = 0; k + 1 < kShapeCount; ++k) {
    if (!kShapeNames[k].ends_with("_L") || head.delta[k].empty() || head.delta[k + 1].empty()) continue;
    const auto mean_x = [&](std::size_t shape_index) {
      double sum = 0;
      double weight = 0;
      for (const auto& [vertex, delta] : head.delta[shape_index]) {
        sum += delta.norm() * head.position[vertex].x();
        weight += delta.norm();
      }
      return weight > 0 ? sum / weight : 0.0;
    };
    difference += mean_x(k) - mean_x(k + 1);
  }
  return difference;
}

/// The unit in which the moving part of the face is as large as a person's, from brow to chin and cheek to
/// cheek.
double guess_unit(double extent) {
  constexpr double kPerson = 0.19;  // ICT's: 0.17 to 0.2 m; drawn characters keep within a factor of 2.2.
  for (const double unit : {1.0, 0.01, 0.001, 0.0254})
    if (const double size = extent * unit; size > kPerson / 2.2 && size < kPerson * 2.2) return unit;
  return 0.2 / extent;
}

Result<GltfHead> finish(Assembly& head, const Binding& binding, const std::string& name) {
  GltfHead result;
  Face& face = result.face;
  face.name = fs::path(name).stem().string();

  // What really moves, by at least a hundredth of the farthest: stray vertices say nothing about size.
  double peak = 0;
  for (const auto& shape_delta : head.delta)
    for (const auto& [vertex, delta] : shape_delta) peak = std::max(peak, delta.norm());
  Eigen::AlignedBox3d moving;
  for (const auto& shape_delta : head.delta)
    for (const auto& [vertex, delta] : shape_delta)
      if (delta.norm() > 0.01 * peak) moving.extend(head.position[vertex]);
  const double extent = moving.isEmpty() ? 0.0 : moving.sizes().maxCoeff();
  if (!(extent > 1e-9) || !(peak > 0)) return fail(ErrorCode::malformed, "its shapes move nothing", name);
  const double unit = guess_unit(extent);
  result.metres_per_unit = unit;
  if (unit != 1.0)
    result.warnings.push_back(
        fmt::format("one unit of the file is taken as {:.4g} m, by the size of the face", unit));

  const double sides = left_minus_right(head);
  const bool backwards = looks_backwards(head, sides);
  if ((backwards ? -sides : sides) < 0)
    result.warnings.push_back(
        "its left shapes lie on the performer's right: the names seem to be the viewer's");
  const double turn = backwards ? -1 : 1;  // Half a turn about +Y.
  const auto metres = [&](const Vec3& v) -> Vec3 { return unit * Vec3(turn * v.x(), v.y(), turn * v.z()); };
  const Vec3 middle = metres(moving.center());

  for (const Vec3& v : head.position) face.neutral_m.push_back(metres(v).cast<float>());
  face.triangles = std::move(head.triangles);
  face.parts = std::move(head.parts);
  if (head.has_uv) face.uv = std::move(head.uv);
  if (head.has_colour) face.colour = std::move(head.colour);

  constexpr double kRamp_m = 0.02;
  for (std::size_t k = 0; k <= kShapeCount; ++k) {
    if (k == kTongueOutPlace && head.delta[k].empty()) break;
    Shape& s = face.shapes.emplace_back();
    s.name = shape_name(k);
    const double side = s.name.ends_with("_L") ? 1 : -1;
    for (const auto& [vertex, delta] : head.delta[k]) {
      double share = 1;
      if (binding.split[k]) {
        const double x = metres(head.position[vertex]).x() - middle.x();
        share = smoothstep(0.5 + 0.5 * side * x / kRamp_m);
      }
      if (share == 0) continue;
      s.vertex.push_back(vertex);
      s.delta_m.push_back((share * metres(delta)).cast<float>());
    }
    if (s.vertex.empty()) result.missing.push_back(s.name);
  }

  Region skin{"skin", {}};
  for (std::uint32_t v = 0; v < head.skin.size(); ++v)
    if (head.skin[v]) skin.vertex.push_back(v);
  if (skin.vertex.empty()) {
    // No mesh is called skin or the like: what moves is.
    std::set<std::uint32_t> moved;
    for (const Shape& s : face.shapes) moved.insert(s.vertex.begin(), s.vertex.end());
    skin.vertex.assign(moved.begin(), moved.end());
  }
  face.regions.push_back(std::move(skin));

  // Whose eye it is shows in where it is: files name them by either point of view.
  for (const Assembly::Eye& eye : head.eyes) {
    Eigen::AlignedBox3f box;
    for (std::uint32_t v = eye.first; v < eye.first + eye.count; ++v) box.extend(face.neutral_m[v]);
    const Vec3f centre = eye.pivot ? Vec3f(metres(*eye.pivot).cast<float>()) : Vec3f(box.center());
    const float offset = box.center().x() - static_cast<float>(middle.x());
    if (std::abs(offset) < 0.005F) continue;  // Both eyes in one mesh: they cannot turn apart.
    Eyeball& ball = face.eyes[offset > 0 ? 0 : 1];
    if (ball.vertex_count < eye.count) ball = {eye.first, eye.count, centre};
  }
  if (!result.missing.empty())
    result.warnings.push_back(
        fmt::format("{} shapes are missing: {}", result.missing.size(), fmt::join(result.missing, ", ")));
  return result;
}

Result<GltfHead> read_head(std::span<const std::byte> bytes, const std::string& name, Folder& folder) {
  MIEN_TRY_ASSIGN(const tinygltf::Model model, read_container(bytes, name, folder));
  const Arrays arrays(model, name);
  const Binding binding = bind_shapes(model);
  if (binding.count > kMaxBinds)
    return fail(ErrorCode::out_of_range, fmt::format("it binds more than {} morph targets", kMaxBinds), name);
  if (binding.count == 0)
    return fail(ErrorCode::not_found, "no morph target has an ARKit name such as jawOpen or eyeBlinkLeft",
                name, "export the head with its shape key names (mesh extras, targetNames)");
  MIEN_TRY_ASSIGN(const auto placed, place_nodes(model, arrays));
  std::vector<Mat4> worlds(model.nodes.size(), Mat4::Identity());
  for (const Placed& p : placed) worlds[static_cast<std::size_t>(p.node)] = p.world;
  Assembly head;
  for (const Placed& p : placed)
    if (model.nodes[static_cast<std::size_t>(p.node)].mesh >= 0)
      MIEN_TRY(add_mesh(model, p, worlds, binding, head, arrays));
  return finish(head, binding, name);
}

}  // namespace

std::vector<std::size_t> shapes_of_name(std::string_view name) {
  // "Face.eyeBlink_L", "mesh:eyeBlink_L": exporters put the owner in front.
  if (const std::size_t dot = name.find_last_of(".:|"); dot != std::string_view::npos)
    name = name.substr(dot + 1);
  const auto& table = name_table();
  const auto found = table.find(plain(name));
  return found == table.end() ? std::vector<std::size_t>{} : found->second;
}

Result<GltfHead> import_gltf(const fs::path& path) {
  MIEN_TRY_ASSIGN(const auto bytes, read_file(path, kMaxBytes));
  std::error_code code;
  Folder folder{fs::canonical(path, code).parent_path()};
  return read_head(bytes, path.string(), folder);
}

Result<GltfHead> parse_gltf(std::span<const std::byte> bytes, std::string_view name) {
  Folder nothing;
  return read_head(bytes, std::string(name), nothing);
}

}  // namespace mien::face
