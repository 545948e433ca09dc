#include "mien/builtin_face/load_face.h"

#include <charconv>
#include <filesystem>
#include <string_view>

#include "mien/builtin_face/builtin_face.h"
#include "mien/face/gltf_import.h"
#include "mien/face/ict_import.h"

namespace mien::builtin_face {
namespace fs = std::filesystem;

Result<face::Face> load_face(const std::string& what, const Progress& progress) {
  if (what == "builtin") return make_builtin({.hair = HairStyle::crop});
  constexpr std::string_view kPerson = "builtin:";
  if (what.starts_with(kPerson)) {
    std::uint64_t seed = 0;
    const char* end = what.data() + what.size();
    const auto [stop, problem] = std::from_chars(what.data() + kPerson.size(), end, seed);
    if (problem != std::errc() || stop != end)
      return fail(ErrorCode::bad_usage, "a person of the built-in family is named by a number", what,
                  "such as builtin:7");
    Random random(seed);
    return make_builtin(random_identity(random));
  }
  std::error_code code;
  const fs::path path = what;
  if (fs::is_directory(path, code)) {
    for (const fs::path& folder : {path, path / "FaceXModel"})
      if (fs::exists(folder / "generic_neutral_mesh.obj", code)) return face::import_ict(folder, progress);
    return fail(ErrorCode::not_found, "there is no generic_neutral_mesh.obj in this folder", what,
                "name the FaceXModel folder of ICT-FaceKit");
  }
  if (!fs::exists(path, code))
    return fail(ErrorCode::not_found, "there is no such face", what,
                "name 'builtin', a folder or a .glb, .gltf or .vrm file");
  std::string ending = path.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (ending == ".glb" || ending == ".gltf" || ending == ".vrm") {
    MIEN_TRY_ASSIGN(face::GltfHead head, face::import_gltf(path));
    return std::move(head.face);
  }
  return fail(ErrorCode::unsupported, "this is no face that Mien reads", what,
              "name 'builtin', a folder with generic_neutral_mesh.obj, or a .glb, .gltf or .vrm file");
}

}  // namespace mien::builtin_face
