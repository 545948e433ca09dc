#include "mien/face/gltf/assembly.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <set>
#include <string>

#include "mien/core/excerpt.h"
#include "mien/face/gltf/names.h"

namespace mien::face::gltf {
namespace {

/// Ribbons of hairs as our own exports have them. Of others' hair nobody knows what its texture coordinates
/// mean.
bool is_strands(const tinygltf::Material* material, const tinygltf::Primitive& primitive) {
  return material != nullptr && material->name == material_name(Material::strands) &&
         primitive.attributes.contains("TEXCOORD_0");
}

using Mat4 = Eigen::Matrix4d;

inline constexpr std::size_t kMaxVertices = 4'000'000;
inline constexpr std::size_t kMaxDeltas = 10'000'000;

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
                excerpt(node.name));
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
      return fail(ErrorCode::out_of_range, "a vertex lies beyond all bounds", excerpt(node.name));
    out.position.push_back(at_v);
  }

  const tinygltf::Material* material = at(model.materials, primitive.material);
  if (const auto uv_at = primitive.attributes.find("TEXCOORD_0"); uv_at != primitive.attributes.end()) {
    out.has_uv = true;
    MIEN_TRY_ASSIGN(const auto uv, arrays.read(uv_at->second, 2, vertices));
    for (std::size_t v = 0; v < vertices; ++v)
      out.uv.emplace_back(static_cast<float>(uv[2 * v]), static_cast<float>(uv[2 * v + 1]));
  } else {
    out.uv.insert(out.uv.end(), vertices, Eigen::Vector2f::Zero());
  }
  // Colours: the vertices' own and the factor where no picture is laid over them, as one is over strands,
  // whose picture says only which places are hair.
  const bool pictured = material != nullptr && material->pbrMetallicRoughness.baseColorTexture.index >= 0;
  const bool strands = is_strands(material, primitive);
  Vec3f factor = Vec3f::Ones();
  if (material != nullptr && material->pbrMetallicRoughness.baseColorFactor.size() == 4)
    for (int c = 0; c < 3; ++c)
      factor[c] = std::clamp(
          static_cast<float>(material->pbrMetallicRoughness.baseColorFactor[static_cast<std::size_t>(c)]),
          0.0F, 1.0F);
  // Our own exports keep colours that their picture shows under a name that others leave alone.
  const auto kept_at = primitive.attributes.find("_COLOR_0");
  const bool kept = kept_at != primitive.attributes.end();
  const auto colour_at = kept ? kept_at : primitive.attributes.find("COLOR_0");
  const bool own = colour_at != primitive.attributes.end() && (!pictured || strands || kept);
  if (own) {
    const tinygltf::Accessor* accessor = at(model.accessors, colour_at->second);
    const std::size_t width = accessor != nullptr && accessor->type == TINYGLTF_TYPE_VEC3 ? 3 : 4;
    MIEN_TRY_ASSIGN(const auto rows, arrays.read(colour_at->second, width, vertices));
    for (std::size_t v = 0; v < vertices; ++v) {
      Vec3f colour;
      for (int c = 0; c < 3; ++c)
        colour[c] = factor[c] *
                    static_cast<float>(std::clamp(rows[width * v + static_cast<std::size_t>(c)], 0.0, 1.0));
      out.colour.push_back(colour);
    }
  } else if (material != nullptr && !pictured) {
    out.colour.insert(out.colour.end(), vertices, factor);
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
        return fail(ErrorCode::out_of_range, "a morph target moves beyond all bounds", excerpt(node.name));
      if (moved[v].isZero(0)) continue;
      if (++out.delta_count > kMaxDeltas) return arrays.bad("its morph targets move too many vertices");
      out.delta[k].emplace_back(first + static_cast<std::uint32_t>(v), moved[v]);
    }
  }
  out.skin.resize(out.position.size());
  return Shared{&primitive, first, vertices, bound};
}

}  // namespace

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
      // Two materials on one vertex have no one colour, unless the vertex has its own.
      if (!primitive.attributes.contains("COLOR_0") && !primitive.attributes.contains("_COLOR_0"))
        out.has_colour = false;
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
    const Material kind = is_strands(material, primitive)
                              ? Material::strands
                              : guess_material(plain(part_name + " " + material_name));
    out.parts.push_back({part_name.empty() ? fmt::format("part_{}", out.parts.size()) : part_name, kind,
                         first_triangle, static_cast<std::uint32_t>(out.triangles.size()) - first_triangle});

    if (kind == Material::strands && out.has_colour) {
      // Once a vertex: its colour stands for the brightest of the ribbon's hairs.
      const std::set<double> of_ribbons(index.begin(), index.end());
      for (const double i : of_ribbons)
        out.colour[mine.first + static_cast<std::size_t>(i)] /= kBrightestStrand;
    }
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

}  // namespace mien::face::gltf
