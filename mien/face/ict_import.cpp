#include "mien/face/ict_import.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "mien/core/files.h"
#include "mien/face/ict_cache.h"
#include "mien/face/obj.h"
#include "mien/face/surface_point.h"

namespace mien::face {
namespace fs = std::filesystem;
namespace {

inline constexpr std::size_t kVertexCount = 26719;
inline constexpr std::size_t kIdentityCount = 100;
inline constexpr float kMetresPerCentimetre = 0.01F;
inline constexpr std::string_view kNeutral = "generic_neutral_mesh";
/// A mesh of the model is 2.6 MB; text beyond this is none.
inline constexpr std::size_t kMaxMeshBytes = std::size_t{64} << 20U;

/// ICT-FaceKit Light keeps its anatomy in runs of vertices (README, "Geometry").
struct Range {
  std::string_view name;
  Material material;
  std::uint32_t first;
  std::uint32_t last;  // The last one itself.
};
inline constexpr std::array<Range, 18> kAnatomy = {{
    {"skin", Material::skin, 0, 9408},
    {"head", Material::skin, 9409, 11247},
    {"mouth_inside", Material::mouth_inside, 11248, 13293},
    {"eye_socket_L", Material::skin, 13294, 13677},
    {"eye_socket_R", Material::skin, 13678, 14061},
    {"gums_tongue", Material::gums, 14062, 17038},
    {"teeth_upper", Material::teeth, 17039, 19246},
    {"teeth_lower", Material::teeth, 19247, 21450},
    {"sclera_L", Material::sclera, 21451, 22220},
    {"iris_L", Material::iris, 22221, 23020},
    {"sclera_R", Material::sclera, 23021, 23790},
    {"iris_R", Material::iris, 23791, 24590},
    // Wet films over the eyes: clear, so they share the cornea's material.
    {"lacrimal_L", Material::cornea, 24591, 24794},
    {"lacrimal_R", Material::cornea, 24795, 24998},
    {"eye_blend", Material::cornea, 24999, 25046},
    {"eye_occlusion", Material::cornea, 25047, 25350},
    {"lashes_L", Material::lash, 25351, 26034},
    {"lashes_R", Material::lash, 26035, 26718},
}};
static_assert(kAnatomy.back().last + 1 == kVertexCount);

/// Parts that are cut out of one of the above by position.
inline constexpr std::array<std::pair<std::string_view, Material>, 6> kCutParts = {{
    {"lips", Material::lips},
    {"tongue", Material::tongue},
    {"cornea_L", Material::cornea},
    {"cornea_R", Material::cornea},
    {"pupil_L", Material::pupil},
    {"pupil_R", Material::pupil},
}};

/// The 68 of Multi-PIE, for a folder without vertex_indices.json, which holds the same.
inline constexpr std::array<std::uint32_t, 68> kLandmarks = {
    1225, 1888, 1052, 367,  1719, 1722, 2199, 1447, 966,  3661, 4390, 3927, 3924, 2608, 3272, 4088, 3443,
    268,  493,  1914, 2044, 1401, 3615, 4240, 4114, 2734, 2509, 978,  4527, 4942, 4857, 1140, 2075, 1147,
    4269, 3360, 1507, 1542, 1537, 1528, 1518, 1511, 3742, 3751, 3756, 3721, 3725, 3732, 5708, 5695, 2081,
    0,    4275, 6200, 6213, 6346, 6461, 5518, 5957, 5841, 5702, 5711, 5533, 6216, 6207, 6470, 5517, 5966};

const Range& range_named(std::string_view name) {
  return *std::ranges::find(kAnatomy, name, &Range::name);
}

/// Eyeball: the shell of the sclera and the ball of the iris lie one after the other.
std::pair<std::uint32_t, std::uint32_t> eyeball_range(std::size_t eye) {
  return {range_named(eye == 0 ? "sclera_L" : "sclera_R").first,
          range_named(eye == 0 ? "iris_L" : "iris_R").last};
}

/// The point that the eye turns about: the centre of the sphere through the back of the sclera. (The mean of
/// the eyeball's vertices, 5.6 mm in front of it, is no centre: the mesh is finer in front, and the cornea
/// bulges.)
Vec3f eye_centre(std::span<const Vec3f> vertices_m, std::size_t eye) {
  const Range& sclera = range_named(eye == 0 ? "sclera_L" : "sclera_R");
  const auto shell = vertices_m.subspan(sclera.first, sclera.last - sclera.first + 1);
  Vec3 mean = Vec3::Zero();
  for (const Vec3f& v : shell) mean += v.cast<double>();
  mean /= static_cast<double>(shell.size());
  // |p - c|^2 = r^2 is linear in c and r^2 - |c|^2; about the mean, so that it is well conditioned.
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const Vec3f& v : shell) {
    const Vec3 p = v.cast<double>() - mean;
    if (p.z() >= 0) continue;
    const Eigen::Vector4d row(2 * p.x(), 2 * p.y(), 2 * p.z(), 1);
    normal += row * row.transpose();
    right += p.squaredNorm() * row;
  }
  const Eigen::Vector4d solution = normal.ldlt().solve(right);
  return solution.allFinite() ? Vec3f((mean + solution.head<3>()).cast<float>()) : Vec3f(mean.cast<float>());
}

void set_eyes(Face& face) {
  for (std::size_t e = 0; e < 2; ++e) {
    const auto [first, last] = eyeball_range(e);
    face.eyes[e] = {first, last - first + 1, eye_centre(face.neutral_m, e)};
  }
}

float distance_to_line(const Vec3f& p, const Vec3f& a, const Vec3f& b) {
  const Vec3f along = b - a;
  const float length2 = along.squaredNorm();
  const float t = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0F, 1.0F) : 0.0F;
  return (a + t * along - p).norm();
}

/// Sorts triangles into parts: by the run of vertices that they belong to, and lips, tongue, cornea and pupil
/// by position, since the model does not mark them.
void set_parts(Face& face) {
  std::vector<std::uint8_t> range_of(face.neutral_m.size());
  for (std::size_t r = 0; r < kAnatomy.size(); ++r)
    std::fill(range_of.begin() + kAnatomy[r].first, range_of.begin() + kAnatomy[r].last + 1,
              static_cast<std::uint8_t>(r));
  std::vector<Eigen::Vector2f> lip_line;
  for (std::size_t i = 48; i < 60; ++i) lip_line.push_back(face.neutral_m[face.landmarks[i]].head<2>());

  // The parts in the order in which they are drawn up: anatomy first, cuts after.
  std::vector<std::pair<std::string_view, Material>> kinds;
  for (const Range& range : kAnatomy) kinds.emplace_back(range.name, range.material);
  kinds.insert(kinds.end(), kCutParts.begin(), kCutParts.end());
  const auto cut = [&](std::string_view name) {
    return static_cast<std::size_t>(std::ranges::find(kinds, name, &decltype(kinds)::value_type::first) -
                                    kinds.begin());
  };
  const std::size_t lips = cut("lips");
  const std::size_t tongue = cut("tongue");
  const std::array<std::size_t, 2> cornea = {cut("cornea_L"), cut("cornea_R")};
  const std::array<std::size_t, 2> pupil = {cut("pupil_L"), cut("pupil_R")};

  // The eye's axis runs from its centre through the front pole of the sclera, the shell's first vertex.
  std::array<Vec3f, 2> axis;
  for (std::size_t e = 0; e < 2; ++e)
    axis[e] = (face.neutral_m[face.eyes[e].first_vertex] - face.eyes[e].centre_m).normalized();
  constexpr float kCorneaRadius = 0.0070F;  // As on the model's eye, which is 1.25 times a real one.
  constexpr float kIrisRadius = 0.0066F;
  constexpr float kPupilRadius = 0.0024F;

  std::vector<std::vector<std::array<std::uint32_t, 3>>> sorted(kinds.size());
  for (const auto& triangle : face.triangles) {
    const Vec3f middle =
        (face.neutral_m[triangle[0]] + face.neutral_m[triangle[1]] + face.neutral_m[triangle[2]]) / 3;
    // Where two runs share an edge, the later one (the smaller part) takes the triangle.
    const std::size_t range = std::max({range_of[triangle[0]], range_of[triangle[1]], range_of[triangle[2]]});
    const std::string_view name = kAnatomy[range].name;
    std::size_t kind = range;
    if (name == "skin") {
      if (inside_polygon(lip_line, middle.head<2>())) kind = lips;
    } else if (name == "gums_tongue") {
      if (std::abs(middle.x()) < 0.0172F && middle.y() > -0.0470F && middle.y() < -0.0240F &&
          middle.z() < 0.0910F)
        kind = tongue;
    } else if (name.starts_with("sclera") || name.starts_with("iris")) {
      const std::size_t e = name.ends_with("_L") ? 0 : 1;
      const Vec3f from_centre = middle - face.eyes[e].centre_m;
      const float depth = from_centre.dot(axis[e]);
      const float radius = depth > 0 ? (from_centre - depth * axis[e]).norm() : 1.0F;
      // The ball of the iris has a hole for a pupil, and its back is the dark that is seen through it.
      if (name.starts_with("sclera"))
        kind = radius < kCorneaRadius ? cornea[e] : range;
      else
        kind = radius >= kPupilRadius && radius < kIrisRadius ? range : pupil[e];
    }
    sorted[kind].push_back(triangle);
  }
  face.triangles.clear();
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    if (sorted[k].empty()) continue;
    face.parts.push_back({std::string(kinds[k].first), kinds[k].second,
                          static_cast<std::uint32_t>(face.triangles.size()),
                          static_cast<std::uint32_t>(sorted[k].size())});
    face.triangles.insert(face.triangles.end(), sorted[k].begin(), sorted[k].end());
  }
}

void add_range_region(Face& face, std::string name, std::uint32_t first, std::uint32_t last) {
  Region& region = face.regions.emplace_back();
  region.name = std::move(name);
  for (std::uint32_t v = first; v <= last; ++v) region.vertex.push_back(v);
}

/// The runs of vertices, and around the landmarks' lines the parts of the skin that people speak of.
void set_regions(Face& face) {
  add_range_region(face, "skin", 0, 9408);
  add_range_region(face, "narrow_face", 0, 6705);
  for (const Range& range : kAnatomy)
    if (range.name != "skin") add_range_region(face, std::string(range.name), range.first, range.last);
  for (std::size_t e = 0; e < 2; ++e) {
    const auto [first, last] = eyeball_range(e);
    add_range_region(face, e == 0 ? "eyeball_L" : "eyeball_R", first, last);
  }
  struct Line {
    std::string_view name;
    std::size_t first_landmark;
    std::size_t last_landmark;
    bool closed;
    float reach_m;
  };
  static constexpr std::array<Line, 7> kLines = {{{"brow_R", 17, 21, false, 0.010F},
                                                  {"brow_L", 22, 26, false, 0.010F},
                                                  {"nose", 27, 35, false, 0.012F},
                                                  {"eye_R", 36, 41, true, 0.010F},
                                                  {"eye_L", 42, 47, true, 0.010F},
                                                  {"mouth", 48, 59, true, 0.015F},
                                                  {"jaw", 0, 16, false, 0.015F}}};
  const Range& skin = range_named("skin");
  for (const Line& line : kLines) {
    Region& region = face.regions.emplace_back();
    region.name = line.name;
    for (std::uint32_t v = skin.first; v <= skin.last; ++v) {
      const Vec3f& p = face.neutral_m[v];
      const auto at = [&](std::size_t landmark) -> const Vec3f& {
        return face.neutral_m[face.landmarks[landmark]];
      };
      float nearest =
          line.closed ? distance_to_line(p, at(line.last_landmark), at(line.first_landmark)) : 1.0F;
      for (std::size_t i = line.first_landmark; i < line.last_landmark; ++i)
        nearest = std::min(nearest, distance_to_line(p, at(i), at(i + 1)));
      if (nearest <= line.reach_m) region.vertex.push_back(v);
    }
  }
  const auto lips = std::ranges::find(face.parts, "lips", &Part::name);
  Region& region = face.regions.emplace_back();
  region.name = "lips";
  if (lips != face.parts.end())
    for (std::uint32_t t = lips->first_triangle; t < lips->first_triangle + lips->triangle_count; ++t)
      region.vertex.insert(region.vertex.end(), face.triangles[t].begin(), face.triangles[t].end());
  std::ranges::sort(region.vertex);
  const auto rest = std::ranges::unique(region.vertex);
  region.vertex.erase(rest.begin(), rest.end());
}

/// Landmarks and rigid vertices from vertex_indices.json, where it is there.
Result<void> read_indices(const fs::path& file, Face& face) {
  face.landmarks = kLandmarks;
  face.has_landmarks = true;
  std::error_code code;
  if (!fs::exists(file, code)) return {};
  MIEN_TRY_ASSIGN(const std::string text, read_text(file, kMaxMeshBytes));
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return fail(ErrorCode::malformed, "this is not a JSON object", file.string());
  const auto indices = [&](const char* key, std::vector<std::uint32_t>& out) -> Result<void> {
    const auto found = json.find(key);
    if (found == json.end()) return {};
    if (!found->is_array())
      return fail(ErrorCode::malformed, fmt::format("{} is not a list", key), file.string());
    for (const auto& value : *found) {
      if (!value.is_number_integer() || value < 0 || value >= kVertexCount)
        return fail(ErrorCode::out_of_range, fmt::format("{} holds what is no vertex", key), file.string());
      out.push_back(value.get<std::uint32_t>());
    }
    return {};
  };
  std::vector<std::uint32_t> landmarks;
  MIEN_TRY(indices("idx_to_landmark_verts", landmarks));
  if (!landmarks.empty()) {
    if (landmarks.size() != face.landmarks.size())
      return fail(ErrorCode::mismatch, fmt::format("there are {} landmarks, not 68", landmarks.size()),
                  file.string());
    std::ranges::copy(landmarks, face.landmarks.begin());
  }
  Region rigid{"rigid", {}};
  MIEN_TRY(indices("idx_to_rigid_verts", rigid.vertex));
  std::ranges::sort(rigid.vertex);
  if (!rigid.vertex.empty()) face.regions.push_back(std::move(rigid));
  return {};
}

Result<ObjMesh> read_mesh(const fs::path& file, ObjContent content) {
  MIEN_TRY_ASSIGN(const std::string text, read_text(file, kMaxMeshBytes));
  MIEN_TRY_ASSIGN(ObjMesh mesh, parse_obj(text, file.string(), content));
  if (mesh.position.size() != kVertexCount)
    return fail(ErrorCode::mismatch,
                fmt::format("it has {} vertices, not the {} of ICT-FaceKit Light", mesh.position.size(),
                            kVertexCount),
                file.string());
  // Heads are 34 cm high; ten metres is no head, and keeps every later sum finite.
  for (const Vec3f& v : mesh.position)
    if (v.cwiseAbs().maxCoeff() > 1000)
      return fail(ErrorCode::out_of_range, "a vertex lies more than ten metres away", file.string(),
                  "the unit of this format is the centimetre");
  return mesh;
}

/// Runs work(0..count-1) on all cores, the caller's own among them; which thread does which never shows in
/// the result. The error is that of the lowest index that failed.
Result<void> in_parallel(std::size_t count, const std::function<Result<void>(std::size_t)>& work,
                         const std::function<bool(std::size_t)>& tell) {
  std::vector<Result<void>> done(count);
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> finished = 0;
  std::atomic<bool> stop = false;
  std::atomic<bool> cancelled = false;
  const auto run = [&](bool tells) {
    while (!stop) {
      const std::size_t i = next++;
      if (i >= count) return;
      done[i] = work(i);
      ++finished;
      if (!done[i]) stop = true;
      if (tells && !tell(finished)) stop = cancelled = true;
    }
  };
  {
    std::vector<std::jthread> others;
    const std::size_t threads =
        std::min<std::size_t>({std::max(std::thread::hardware_concurrency(), 1U), 16, count});
    for (std::size_t t = 1; t < threads; ++t) others.emplace_back(run, false);
    run(true);
  }
  if (cancelled) return fail(ErrorCode::cancelled, "the import was stopped");
  for (const auto& result : done)
    if (!result) return result;
  return {};
}

Result<IctModel> read_model(const fs::path& folder, const IctOptions& options, const Progress& progress) {
  IctModel model;
  Face& face = model.face;
  face.name = "ict";
  face.origin = Origin::ict;
  MIEN_TRY(read_indices(folder / "vertex_indices.json", face));
  MIEN_TRY_ASSIGN(ObjMesh neutral,
                  read_mesh(folder / fmt::format("{}.obj", kNeutral), ObjContent::positions_and_faces));
  face.triangles = std::move(neutral.triangles);
  for (const Vec3f& v : neutral.position) face.neutral_m.push_back(kMetresPerCentimetre * v);

  face.shapes.resize(kShapeCount);
  model.identities.resize(options.identities ? kIdentityCount : 0);
  const std::size_t count = kShapeCount + model.identities.size();
  const auto read_one = [&](std::size_t i) -> Result<void> {
    const bool is_shape = i < kShapeCount;
    const std::string name =
        is_shape ? std::string(kShapeNames[i]) : fmt::format("identity{:03}", i - kShapeCount);
    MIEN_TRY_ASSIGN(const ObjMesh mesh, read_mesh(folder / (name + ".obj"), ObjContent::positions));
    if (is_shape) {
      Shape& s = face.shapes[i];
      s.name = name;
      for (std::uint32_t v = 0; v < kVertexCount; ++v) {
        const Vec3f delta = mesh.position[v] - neutral.position[v];
        // A ten-thousandth of a millimetre: what the files' six decimals leave behind, and no movement.
        if (delta.squaredNorm() <= 1e-10F) continue;
        s.vertex.push_back(v);
        s.delta_m.push_back(kMetresPerCentimetre * delta);
      }
    } else {
      IctIdentity& identity = model.identities[i - kShapeCount];
      identity.name = name;
      identity.delta_m.resize(kVertexCount);
      for (std::size_t v = 0; v < kVertexCount; ++v)
        identity.delta_m[v] = kMetresPerCentimetre * (mesh.position[v] - neutral.position[v]);
    }
    return {};
  };
  MIEN_TRY(in_parallel(count, read_one, [&](std::size_t finished) {
    return progress(static_cast<double>(finished) / static_cast<double>(count), "reading meshes");
  }));
  set_eyes(face);
  set_parts(face);
  set_regions(face);
  return model;
}

std::vector<fs::path> files_of(const fs::path& folder, const IctOptions& options) {
  std::vector<fs::path> files = {folder / fmt::format("{}.obj", kNeutral), folder / "vertex_indices.json"};
  for (const std::string_view name : kShapeNames) files.push_back(folder / fmt::format("{}.obj", name));
  for (std::size_t i = 0; options.identities && i < kIdentityCount; ++i)
    files.push_back(folder / fmt::format("identity{:03}.obj", i));
  return files;
}

}  // namespace

Result<IctModel> import_ict_model(const fs::path& folder, const IctOptions& options,
                                  const Progress& progress) {
  std::error_code code;
  const fs::path real = fs::canonical(folder, code);
  if (code || !fs::is_directory(real, code))
    return fail(ErrorCode::not_found, "there is no such folder", folder.string());
  const fs::path cache = options.cache ? cache_path(real, options) : fs::path();
  std::string key;
  if (!cache.empty()) {
    key = fingerprint(files_of(real, options));
    if (const auto bytes = read_file(cache))
      if (auto model = decode_cache(*bytes, key)) return std::move(*model);
  }
  MIEN_TRY_ASSIGN(IctModel model, read_model(real, options, progress));
  if (!cache.empty()) {
    // A cache is a convenience: where it cannot be kept, the next import is merely slower.
    fs::create_directories(cache.parent_path(), code);
    if (!code) (void)write_file(cache, encode_cache(model, key));
  }
  return model;
}

Result<Face> import_ict(const fs::path& folder, const Progress& progress) {
  MIEN_TRY_ASSIGN(IctModel model, import_ict_model(folder, {}, progress));
  return std::move(model.face);
}

Face with_identity(const IctModel& model, std::span<const float> coefficients) {
  Face face = model.face;
  const std::size_t count = std::min(coefficients.size(), model.identities.size());
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t v = 0; v < face.neutral_m.size(); ++v)
      face.neutral_m[v] += coefficients[i] * model.identities[i].delta_m[v];
  set_eyes(face);
  return face;
}

}  // namespace mien::face
