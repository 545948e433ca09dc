#include "mien/render/gltf_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "mien/core/encoding.h"
#include "mien/core/files.h"
#include "mien/core/time.h"
#include "mien/render/face_textures.h"
#include "mien/render/gltf_asset.h"
#include "mien/render/strands.h"
#include "mien/render/surface_paint.h"
#include "mien/render/vrm.h"

namespace mien::render {
namespace {

using face::Material;
using nlohmann::json;
using TriangleIndices = std::array<std::uint32_t, 3>;

json material_entry(Material material, float roughness) {
  json entry = {{"name", face::material_name(material)},
                {"doubleSided", true},
                {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", roughness}}}};
  const double alpha = material == Material::cornea ? 0.08 : material == Material::lash ? 0.35 : 1.0;
  if (alpha < 1) {
    entry["alphaMode"] = "BLEND";
    entry["pbrMetallicRoughness"]["baseColorFactor"] = {1.0, 1.0, 1.0, alpha};
  }
  return entry;
}

/// Part of the face that becomes one glTF mesh.
struct Piece {
  std::string name;
  std::map<Material, std::vector<TriangleIndices>> triangles;  // Of the face's vertices.
  Vec3f origin_m = Vec3f::Zero();
};

/// An eyeball can be a node when it alone uses its vertices and no shape moves them.
bool turns_alone(const face::Face& face, const face::Eyeball& ball) {
  if (ball.vertex_count == 0 || std::size_t{ball.first_vertex} + ball.vertex_count > face.neutral_m.size())
    return false;
  const auto of_ball = [&](std::uint32_t i) {
    return i >= ball.first_vertex && i < ball.first_vertex + ball.vertex_count;
  };
  for (const TriangleIndices& t : face.triangles)
    if (const auto count = std::ranges::count_if(t, of_ball); count != 0 && count != 3) return false;
  return std::ranges::none_of(face.shapes,
                              [&](const face::Shape& s) { return std::ranges::any_of(s.vertex, of_ball); });
}

Result<void> check(const face::Face& face) {
  const auto bad = [&](ErrorCode code, std::string what) { return fail(code, std::move(what), face.name); };
  const std::size_t n = face.neutral_m.size();
  if (n == 0 || face.triangles.empty())
    return bad(ErrorCode::bad_usage, "a face without triangles cannot be exported");
  for (const Vec3f& p : face.neutral_m)
    if (!p.allFinite()) return bad(ErrorCode::out_of_range, "a vertex is not finite");
  for (const TriangleIndices& t : face.triangles)
    if (std::ranges::max(t) >= n)
      return bad(ErrorCode::malformed, "a triangle names a vertex that is not there");
  for (const face::Shape& s : face.shapes) {
    if (s.vertex.size() != s.delta_m.size() || !std::ranges::is_sorted(s.vertex) ||
        (!s.vertex.empty() && s.vertex.back() >= n))
      return bad(ErrorCode::malformed, fmt::format("the shape {} does not fit the face", s.name));
    for (const Vec3f& d : s.delta_m)
      if (!d.allFinite())
        return bad(ErrorCode::out_of_range, fmt::format("the shape {} is not finite", s.name));
  }
  if (!face.colour.empty() && face.colour.size() != n)
    return bad(ErrorCode::malformed, "colours do not fit the vertices");
  if (!face.uv.empty() && face.uv.size() != n)
    return bad(ErrorCode::malformed, "texture coordinates do not fit the vertices");
  for (const Eigen::Vector2f& uv : face.uv)
    if (!uv.allFinite()) return bad(ErrorCode::out_of_range, "a texture coordinate is not finite");
  return {};
}

/// Of skin, lips and eyeballs.
struct TextureSet {
  bool laid_out = false;  ///< Vertices have texture coordinates.
  bool pictured = false;  ///< And the asset the pictures.
  std::size_t albedo = 0, roughness = 0, normal = 0;
  std::vector<Eigen::Vector4f> tangents;
};

Result<TextureSet> add_pictures(GltfAsset& asset, const face::Face& face, const SurfacePaint& paint,
                                std::span<const Vec3f> normals, const GltfTextures& textures) {
  TextureSet set;
  set.pictured = textures.side_px > 0;
  set.laid_out = set.pictured || textures.beside;
  if (set.laid_out && face.uv.empty())
    return fail(ErrorCode::bad_usage, "a face without texture coordinates cannot have textures", face.name,
                "export it without");
  if (!set.pictured) return set;
  MIEN_TRY_ASSIGN(const TextureFiles files, bake_texture_files(face, paint, textures.side_px));
  set.tangents = tangents_of(face, normals);
  set.albedo = asset.texture(files.albedo, "image/jpeg");
  set.roughness = asset.texture(files.roughness, "image/jpeg");
  set.normal = asset.texture(files.normal, "image/jpeg");
  return set;
}

/// The material's entry, made at its first use.
Result<std::size_t> add_material(GltfAsset& asset, std::map<Material, std::size_t>& materials,
                                 Material material, const face::Face& face, const SurfacePaint& paint,
                                 const TextureSet& set) {
  if (const auto known = materials.find(material); known != materials.end()) return known->second;
  json entry = material_entry(material, paint.at(Vec3f::Zero(), material, nullptr).roughness);
  if (set.pictured && is_textured(material)) {
    json& pbr = entry["pbrMetallicRoughness"];
    pbr["roughnessFactor"] = 1.0;
    pbr["baseColorTexture"] = {{"index", set.albedo}};
    pbr["metallicRoughnessTexture"] = {{"index", set.roughness}};
    if (material == Material::skin || material == Material::lips)
      entry["normalTexture"] = {{"index", set.normal}};
  } else if (set.laid_out && is_textured(material)) {
    entry["extras"] = {{"albedo", kAlbedoFile}, {"roughness", kRoughnessFile}, {"normal", kNormalFile}};
  }
  if (material == Material::strands && !face.uv.empty()) {
    MIEN_TRY_ASSIGN(const auto png, strands_png());
    entry["alphaMode"] = "MASK";
    entry["alphaCutoff"] = 0.4;
    entry["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", asset.texture(png, "image/png")}};
  }
  return materials[material] = asset.add("materials", std::move(entry));
}

/// Adds a mesh and gives its index.
Result<std::size_t> add_mesh(GltfAsset& asset, const face::Face& face, const SurfacePaint& paint,
                             std::map<Material, std::size_t>& materials, const Piece& piece,
                             std::span<const face::MorphTarget> morphs, std::span<const Vec3f> normals,
                             const TextureSet& set) {
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place(face.neutral_m.size(), kNone);
  std::vector<Material> material_of(face.neutral_m.size(), Material::skin);
  for (const auto& [material, triangles] : piece.triangles)
    for (const TriangleIndices& t : triangles)
      for (const std::uint32_t i : t) {
        place[i] = 0;
        material_of[i] = material;
      }
  std::vector<std::uint32_t> used;
  for (std::uint32_t i = 0; i < place.size(); ++i)
    if (place[i] != kNone) {
      place[i] = static_cast<std::uint32_t>(used.size());
      used.push_back(i);
    }

  // Behind the seam a vertex is there twice, the second time at uv.x 0; they come last.
  const std::size_t single = used.size();
  std::vector<std::uint32_t> twin(set.laid_out ? place.size() : 0, kNone);
  for (const auto& [material, triangles] : piece.triangles)
    if (set.laid_out && is_textured(material))
      for (const TriangleIndices& t : triangles) {
        const auto uv = uv_of(face, t);
        for (std::size_t k = 0; k < 3; ++k)
          if (uv[k] != face.uv[t[k]] && twin[t[k]] == kNone) {
            twin[t[k]] = static_cast<std::uint32_t>(used.size());
            used.push_back(t[k]);
          }
      }

  std::vector<Vec3f> positions, unit_normals;
  std::vector<std::array<std::uint16_t, 4>> colours;
  for (const std::uint32_t i : used) {
    positions.push_back(face.neutral_m[i] - piece.origin_m);
    unit_normals.push_back(normals[i]);
    const Vec3f* own = face.colour.empty() ? nullptr : &face.colour[i];
    // What lies between two vertices, some 2 mm apart, is no colour of either.
    Vec3f albedo = paint.at(face.neutral_m[i], material_of[i], own, {.footprint_m = 2e-3F}).albedo;
    if (material_of[i] == Material::cornea) albedo = Vec3f::Ones();
    if (material_of[i] == Material::strands) albedo *= face::kBrightestStrand;
    std::array<std::uint16_t, 4> rgba{0, 0, 0, 65535};
    for (int c = 0; c < 3; ++c)
      rgba[static_cast<std::size_t>(c)] =
          static_cast<std::uint16_t>(std::clamp(albedo[c], 0.0F, 1.0F) * 65535 + 0.5F);
    colours.push_back(rgba);
  }
  json attributes = {{"POSITION", asset.vectors(positions, true)},
                     {"NORMAL", asset.vectors(unit_normals, false)},
                     {"COLOR_0", asset.colours(colours)}};
  const bool laid_out = set.laid_out && std::ranges::any_of(piece.triangles, [](const auto& of) {
                          return is_textured(of.first);
                        });
  if ((laid_out || piece.triangles.contains(Material::strands)) && !face.uv.empty()) {
    std::vector<Eigen::Vector2f> uv;
    for (const std::uint32_t i : used) uv.push_back(face.uv[i]);
    for (std::size_t i = single; i < uv.size(); ++i) uv[i].x() -= 1;
    attributes["TEXCOORD_0"] = asset.texture_coordinates(uv);
  }
  // A picture has the colours already; importers of ours read them under a name that others leave alone.
  json textured = attributes;
  if (laid_out && set.pictured) {
    textured["_COLOR_0"] = textured["COLOR_0"];
    textured.erase("COLOR_0");
    std::vector<Eigen::Vector4f> tangents;
    for (const std::uint32_t i : used) tangents.push_back(set.tangents[i]);
    if (piece.triangles.contains(Material::skin)) textured["TANGENT"] = asset.tangents(tangents);
  }

  json targets = json::array(), names = json::array();
  for (const face::MorphTarget& morph : morphs) {
    std::vector<std::uint32_t> index;
    std::vector<Vec3f> delta;
    for (std::size_t k = 0; k < morph.vertex.size(); ++k)
      if (place[morph.vertex[k]] != kNone) {
        index.push_back(place[morph.vertex[k]]);
        delta.push_back(morph.delta_m[k]);
      }
    for (std::size_t i = single; i < used.size(); ++i)
      if (const auto at = std::ranges::lower_bound(morph.vertex, used[i]);
          at != morph.vertex.end() && *at == used[i]) {
        index.push_back(static_cast<std::uint32_t>(i));
        delta.push_back(morph.delta_m[static_cast<std::size_t>(at - morph.vertex.begin())]);
      }
    targets.push_back({{"POSITION", asset.sparse_vectors(std::move(index), std::move(delta), used.size())}});
    names.push_back(morph.name);
  }

  json primitives = json::array();
  for (const auto& [material, triangles] : piece.triangles) {
    std::vector<TriangleIndices> local;
    const bool is_textured_here = laid_out && is_textured(material);
    for (const TriangleIndices& t : triangles) {
      TriangleIndices corner = {place[t[0]], place[t[1]], place[t[2]]};
      if (is_textured_here) {
        const auto uv = uv_of(face, t);
        for (std::size_t k = 0; k < 3; ++k)
          if (uv[k] != face.uv[t[k]]) corner[k] = twin[t[k]];
      }
      local.push_back(corner);
    }
    MIEN_TRY_ASSIGN(const std::size_t dressed, add_material(asset, materials, material, face, paint, set));
    json primitive = {{"attributes", is_textured_here ? textured : attributes},
                      {"indices", asset.indices(local)},
                      {"material", dressed}};
    if (!targets.empty()) primitive["targets"] = targets;
    primitives.push_back(std::move(primitive));
  }
  json mesh = {{"name", piece.name}, {"primitives", std::move(primitives)}};
  if (!targets.empty()) {
    mesh["weights"] = std::vector<double>(names.size(), 0.0);
    mesh["extras"] = {{"targetNames", std::move(names)}};
  }
  return asset.add("meshes", std::move(mesh));
}

void append(std::vector<float>& track, const Quat& rotation) {
  // Neighbouring keys on the same side, or a reader's interpolation goes the long way round.
  Quat q = canonical(rotation);
  if (track.size() >= 4) {
    const float* last = track.data() + track.size() - 4;
    if (q.x() * last[0] + q.y() * last[1] + q.z() * last[2] + q.w() * last[3] < 0) q.coeffs() = -q.coeffs();
  }
  for (const double c : {q.x(), q.y(), q.z(), q.w()}) track.push_back(static_cast<float>(c));
}

Quat eye_rotation(const face::BlendshapeWeights& w, bool left) {
  using face::shape;
  const double yaw = left ? w[shape("eyeLookOut_L")] - w[shape("eyeLookIn_L")]
                          : w[shape("eyeLookIn_R")] - w[shape("eyeLookOut_R")];
  const double pitch = left ? w[shape("eyeLookUp_L")] - w[shape("eyeLookDown_L")]
                            : w[shape("eyeLookUp_R")] - w[shape("eyeLookDown_R")];
  return Eigen::AngleAxisd(face::kEyeTurnRadPerUnit * yaw, Vec3::UnitY()) *
         Eigen::AngleAxisd(-face::kEyeTurnRadPerUnit * pitch, Vec3::UnitX());
}

struct NodeNames {
  std::size_t head = 0, face = 0;
  std::array<std::size_t, 2> eye{};
  std::array<bool, 2> has_eye{};
};

Result<void> add_animation(GltfAsset& asset, std::span<const face::MorphTarget> morphs,
                           const face::Motion& motion, const NodeNames& nodes, const Vec3f& rest_m) {
  const face::MotionCurve curve(motion);
  const auto last_frame = static_cast<std::int64_t>(std::floor(motion.duration_s() * kFrameRateHz + 1e-6));
  std::vector<float> times, weights, head, position;
  bool moves = false;
  std::array<std::vector<float>, 2> eyes;
  for (std::int64_t i = 0; i <= last_frame; ++i) {
    const double time_s = to_seconds(frame_offset(i));
    const face::MotionFrame frame = curve.at(time_s);
    times.push_back(static_cast<float>(time_s));
    for (const face::MorphTarget& morph : morphs)
      weights.push_back(face::weight_of(morph, frame.weights, frame.tongue_out));
    append(head, frame.head);
    moves = moves || !frame.head_position_m.isZero(0);
    for (int c = 0; c < 3; ++c) position.push_back(rest_m[c] + static_cast<float>(frame.head_position_m[c]));
    for (std::size_t e = 0; e < 2; ++e) append(eyes[e], eye_rotation(frame.weights, e == 0));
  }
  for (const auto* track : {&times, &weights, &head, &position, &eyes[0], &eyes[1]})
    for (const float value : *track)
      if (!std::isfinite(value))
        return fail(ErrorCode::out_of_range, "the motion has a number that is not finite", motion.name);

  json samplers = json::array(), channels = json::array();
  const std::size_t input = asset.track(times, "SCALAR", 1, true);
  const auto add = [&](std::size_t node, const char* path, std::size_t output) {
    channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers.push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
  };
  if (!morphs.empty()) add(nodes.face, "weights", asset.track(weights, "SCALAR", 1, false));
  add(nodes.head, "rotation", asset.track(head, "VEC4", 4, false));
  if (moves) add(nodes.head, "translation", asset.track(position, "VEC3", 3, false));
  for (std::size_t e = 0; e < 2; ++e)
    if (nodes.has_eye[e]) add(nodes.eye[e], "rotation", asset.track(eyes[e], "VEC4", 4, false));
  asset.tree["animations"] = {{{"name", motion.name.empty() ? "performance" : motion.name},
                               {"samplers", std::move(samplers)},
                               {"channels", std::move(channels)}}};
  return {};
}

face::TargetNames target_names(GltfNames names) {
  switch (names) {
    case GltfNames::unified:
      return face::TargetNames::unified;
    case GltfNames::arkit:
    case GltfNames::vrm:
      return face::TargetNames::arkit;
    case GltfNames::ict:
      break;
  }
  return face::TargetNames::ict;
}

}  // namespace

Result<std::vector<std::byte>> encode_gltf(const face::Face& face, const face::Motion* motion, GltfKind kind,
                                           GltfNames names, const GltfTextures& textures) {
  MIEN_TRY(check(face));
  const bool avatar = names == GltfNames::vrm;
  Vec3f origin_m = Vec3f::Zero();
  if (avatar) {
    if (kind == GltfKind::text)
      return fail(ErrorCode::bad_usage, "an avatar by VRM is binary glTF", face.name, "name it .vrm or .glb");
    MIEN_TRY_ASSIGN(origin_m, head_origin_m(face));
  }
  if (motion != nullptr && motion->frames.empty())
    return fail(ErrorCode::bad_usage, "the motion has no frames", motion->name);

  const std::vector<Material> material = material_of_triangles(face);
  std::array<Piece, 4> pieces;  // The face, left eye, right eye, and hair that no shape moves.
  pieces[0] = {.name = "face", .triangles = {}, .origin_m = Vec3f::Zero()};
  for (std::size_t e = 0; e < 2; ++e)
    pieces[e + 1] = {.name = e == 0 ? "eye_L" : "eye_R", .triangles = {}, .origin_m = face.eyes[e].centre_m};
  pieces[3] = {.name = "hair", .triangles = {}, .origin_m = Vec3f::Zero()};
  std::vector<bool> moves(face.neutral_m.size(), false);
  for (const face::Shape& shape : face.shapes)
    for (const std::uint32_t i : shape.vertex) moves[i] = true;
  const std::array<bool, 2> alone = {turns_alone(face, face.eyes[0]), turns_alone(face, face.eyes[1])};
  for (std::size_t t = 0; t < face.triangles.size(); ++t) {
    std::size_t piece = 0;
    for (std::size_t e = 0; e < 2; ++e)
      if (const std::uint32_t i = face.triangles[t][0];
          alone[e] && i >= face.eyes[e].first_vertex &&
          i < face.eyes[e].first_vertex + face.eyes[e].vertex_count)
        piece = e + 1;
    if (material[t] == Material::strands &&
        std::ranges::none_of(face.triangles[t], [&](std::uint32_t i) { return moves[i]; }))
      piece = 3;
    pieces[piece].triangles[material[t]].push_back(face.triangles[t]);
  }
  if (pieces[0].triangles.empty())
    return fail(ErrorCode::bad_usage, "a face of eyes and still hair alone cannot be exported", face.name);

  GltfAsset asset;
  const SurfacePaint paint(face, textures.marks);
  std::vector<Vec3f> normals(face.neutral_m.size());
  face::vertex_normals(face, face.neutral_m, normals);
  round_hair(face.neutral_m, face.vertices_of(Material::strands), middle_of_head_m(face), normals);
  MIEN_TRY_ASSIGN(const TextureSet set, add_pictures(asset, face, paint, normals, textures));
  std::map<Material, std::size_t> materials;
  const std::vector<face::MorphTarget> morphs = face::morph_targets(face, target_names(names));

  NodeNames nodes;
  json children = json::array();
  const auto add_still = [&](const Piece& piece,
                             std::span<const face::MorphTarget> targets) -> Result<std::size_t> {
    MIEN_TRY_ASSIGN(const std::size_t mesh,
                    add_mesh(asset, face, paint, materials, piece, targets, normals, set));
    const std::size_t node = asset.add("nodes", {{"name", piece.name}, {"mesh", mesh}});
    if (origin_m != Vec3f::Zero())
      asset.tree["nodes"][node]["translation"] = {-origin_m.x(), -origin_m.y(), -origin_m.z()};
    children.push_back(node);
    return node;
  };
  MIEN_TRY_ASSIGN(nodes.face, add_still(pieces[0], morphs));
  if (!pieces[3].triangles.empty()) MIEN_TRY(add_still(pieces[3], {}));
  for (std::size_t e = 0; e < 2; ++e) {
    if (pieces[e + 1].triangles.empty()) continue;
    const Vec3f at = pieces[e + 1].origin_m - origin_m;
    nodes.has_eye[e] = true;
    MIEN_TRY_ASSIGN(const std::size_t mesh,
                    add_mesh(asset, face, paint, materials, pieces[e + 1], {}, normals, set));
    nodes.eye[e] = asset.add(
        "nodes", {{"name", pieces[e + 1].name}, {"mesh", mesh}, {"translation", {at.x(), at.y(), at.z()}}});
    children.push_back(nodes.eye[e]);
  }
  nodes.head = asset.add("nodes", {{"name", "head"}, {"children", std::move(children)}});
  std::size_t root = nodes.head;
  Vec3f rest_m = Vec3f::Zero();  // Of the head, in its parent's frame.
  if (avatar) {
    std::array<std::optional<std::size_t>, 2> eyes;
    for (std::size_t e = 0; e < 2; ++e)
      if (nodes.has_eye[e]) eyes[e] = nodes.eye[e];
    Skeleton skeleton = add_skeleton(asset.tree["nodes"], nodes.head, eyes);
    root = skeleton.root;
    rest_m = skeleton.head_m;
    asset.tree["extensionsUsed"] = {"VRMC_vrm"};
    asset.tree["extensions"]["VRMC_vrm"] =
        vrm_extension(face, origin_m, morphs, nodes.face, eyes[0] && eyes[1], std::move(skeleton.humanoid));
  }
  asset.tree["scenes"] = {{{"name", face.name.empty() ? "face" : face.name}, {"nodes", {root}}}};
  asset.tree["scene"] = 0;
  if (motion != nullptr) MIEN_TRY(add_animation(asset, morphs, *motion, nodes, rest_m));

  while (asset.buffer.bytes().size() % 4 != 0) asset.buffer.little(std::uint8_t{0});
  const auto buffer = asset.buffer.bytes();
  if (buffer.size() > std::numeric_limits<std::uint32_t>::max() / 2)
    return fail(ErrorCode::out_of_range, "the asset would be larger than glTF's 4 GB", face.name,
                "export a shorter motion");
  json described = {{"byteLength", buffer.size()}};
  if (kind == GltfKind::text) described["uri"] = "data:application/octet-stream;base64," + base64(buffer);
  asset.tree["buffers"] = json::array({std::move(described)});

  std::string text = asset.tree.dump(-1, ' ', false, json::error_handler_t::replace);
  ByteWriter file;
  if (kind == GltfKind::text) {
    file.append(text);
    return file.release();
  }
  while (text.size() % 4 != 0) text += ' ';
  file.append("glTF");
  file.little(std::uint32_t{2});
  file.little(static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + buffer.size()));
  file.little(static_cast<std::uint32_t>(text.size()));
  file.append("JSON");
  file.append(text);
  file.little(static_cast<std::uint32_t>(buffer.size()));
  file.append(std::string_view("BIN\0", 4));
  file.append(buffer);
  return file.release();
}

Result<void> write_gltf(const std::filesystem::path& path, const face::Face& face, const face::Motion* motion,
                        GltfNames names, const GltfTextures& textures) {
  const std::string ending = path.extension().string();
  if (ending != ".glb" && ending != ".gltf" && !(names == GltfNames::vrm && ending == ".vrm"))
    return fail(ErrorCode::bad_usage, fmt::format("'{}' is no ending of glTF", ending), path.string(),
                "name it .glb or .gltf");
  MIEN_TRY_ASSIGN(
      const auto content,
      encode_gltf(face, motion, ending == ".gltf" ? GltfKind::text : GltfKind::binary, names, textures));
  return write_file(path, content);
}

}  // namespace mien::render
