#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "app/chosen_face.h"
#include "app/command.h"
#include "app/gltf_option.h"
#include "app/json_output.h"
#include "mien/core/files.h"
#include "mien/face/obj.h"
#include "mien/render/gltf_export.h"

namespace mien::app {
namespace {

namespace fs = std::filesystem;

/// Extent of the neutral face along each axis, mm.
Vec3f size_mm(const face::Face& face) {
  Eigen::AlignedBox3f box;
  for (const Vec3f& v : face.neutral_m) box.extend(v);
  return face.neutral_m.empty() ? Vec3f(Vec3f::Zero()) : Vec3f(1000 * box.sizes());
}

Json describe(const face::Face& face) {
  Json json;
  json["name"] = face.name;
  json["vertices"] = face.neutral_m.size();
  json["triangles"] = face.triangles.size();
  const Vec3f size = size_mm(face);
  json["size_mm"] = {size.x(), size.y(), size.z()};
  json["shapes"] = Json::array();
  for (const face::Shape& s : face.shapes)
    json["shapes"].push_back({{"name", s.name},
                              {"vertices", s.vertex.size()},
                              {"peak_mm", 1000 * face::peak_displacement_m(face, s.name)}});
  json["landmarks"] = Json::array();
  if (face.has_landmarks)
    for (const std::uint32_t vertex : face.landmarks) json["landmarks"].push_back(vertex);
  json["regions"] = Json::array();
  for (const face::Region& region : face.regions)
    json["regions"].push_back({{"name", region.name}, {"vertices", region.vertex.size()}});
  json["parts"] = Json::array();
  for (const face::Part& part : face.parts)
    json["parts"].push_back({{"name", part.name},
                             {"material", face::material_name(part.material)},
                             {"triangles", part.triangle_count}});
  json["eyes"] = Json::array();
  for (const face::Eyeball& eye : face.eyes)
    json["eyes"].push_back(
        {{"vertices", eye.vertex_count},
         {"centre_mm", {1000 * eye.centre_m.x(), 1000 * eye.centre_m.y(), 1000 * eye.centre_m.z()}}});
  return json;
}

void print_face(const face::Face& face) {
  const Vec3f size = size_mm(face);
  fmt::print("{}: {} vertices, {} triangles, {:.0f} x {:.0f} x {:.0f} mm\n", one_line(face.name),
             face.neutral_m.size(), face.triangles.size(), size.x(), size.y(), size.z());
  fmt::print("landmarks: {}\n", face.has_landmarks ? "68" : "none");
  for (std::size_t e = 0; e < face.eyes.size(); ++e)
    fmt::print(
        "{} eyeball: {}\n", e == 0 ? "left" : "right",
        face.eyes[e].vertex_count > 0 ? fmt::format("{} vertices", face.eyes[e].vertex_count) : "unknown");
  fmt::print("\n{:<18} {:>9} {:>9}\n", "shape", "peak mm", "vertices");
  for (const face::Shape& s : face.shapes)
    if (s.vertex.empty())
      fmt::print("{:<18} {:>9}\n", s.name, "missing");
    else
      fmt::print("{:<18} {:>9.2f} {:>9}\n", s.name, 1000 * face::peak_displacement_m(face, s.name),
                 s.vertex.size());
  fmt::print("\n{:<18} {:>9}\n", "region", "vertices");
  for (const face::Region& region : face.regions)
    fmt::print("{:<18} {:>9}\n", one_line(region.name), region.vertex.size());
  fmt::print("\n{:<18} {:>9}  material\n", "part", "triangles");
  for (const face::Part& part : face.parts)
    fmt::print("{:<18} {:>9}  {}\n", one_line(part.name), part.triangle_count,
               face::material_name(part.material));
}

struct FaceArguments {
  std::string face = "builtin";
  std::string out;
  std::string names;
  std::string textures;
  bool json = false;
};

Result<void> show(const FaceArguments& arguments) {
  MIEN_TRY_ASSIGN(const face::Face face, chosen_face(arguments.face, face_progress(arguments.face)));
  if (arguments.json)
    print_json(describe(face));
  else
    print_face(face);
  return {};
}

Result<void> export_face(const FaceArguments& arguments) {
  const fs::path out = arguments.out;
  const render::GltfNames names = gltf_names(arguments.names, out);
  MIEN_TRY(check_gltf_output(out, names, ".obj"));
  const bool obj = out.extension() == ".obj";
  if (obj && !arguments.names.empty())
    return fail(ErrorCode::bad_usage, "an .obj holds the neutral face alone, without morph targets",
                "--names", "write a .glb or .gltf");
  if (obj && !arguments.textures.empty() && arguments.textures != "none")
    return fail(ErrorCode::bad_usage, "an .obj has no textures", "--textures", "write a .glb or .gltf");
  MIEN_TRY_ASSIGN(const TexturedFace made, textured_face(arguments.face, obj ? "none" : arguments.textures,
                                                         face_progress(arguments.face)));
  if (obj)
    MIEN_TRY(write_file(out, face::format_obj(made.face, made.face.neutral_m)));
  else
    MIEN_TRY(render::write_gltf(out, made.face, nullptr, names, made.textures));
  if (arguments.json)
    print_json(Json{{"file", out.string()}, {"face", made.face.name}});
  else
    fmt::print("wrote {}\n", out.string());
  return {};
}

}  // namespace

void add_face_command(Commands& commands) {
  const auto arguments = std::make_shared<FaceArguments>();
  const Command face = commands.add("face", "Shows what a face model is made of", "mien face --face builtin",
                                    [arguments] { return show(*arguments); });
  face.add_option("--face", arguments->face, kFaceHelp).show_default();
  add_json_flag(face, arguments->json);
  const Command exported =
      commands.add_under(face, "export", "Writes the face to a file that other programs open",
                         "mien face export --face builtin --names arkit --out face.glb",
                         [arguments] { return export_face(*arguments); });
  exported.add_option("--face", arguments->face, kFaceHelp).show_default();
  exported
      .add_option("--out", arguments->out, "The file to write: .obj (the neutral face), .glb, .gltf or .vrm")
      .required();
  add_names_option(exported, arguments->names);
  add_textures_option(exported, arguments->textures);
  add_json_flag(exported, arguments->json);
  add_face_profiles_command(commands, face);
}

}  // namespace mien::app
