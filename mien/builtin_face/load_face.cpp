#include "mien/builtin_face/load_face.h"

#include <algorithm>
#include <filesystem>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/person.h"
#include "mien/core/ascii.h"
#include "mien/face/gltf_import.h"
#include "mien/face/ict_import.h"

namespace mien::builtin_face {
namespace fs = std::filesystem;

Result<face::Face> load_face(const std::string& what, const Progress& progress) {
  if (names_person(what)) {
    MIEN_TRY_ASSIGN(const Person person, find_person(what));
    return make_builtin(person.parameters);
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
  std::ranges::transform(ending, ending.begin(), ascii_lower);
  if (ending == ".glb" || ending == ".gltf" || ending == ".vrm") {
    MIEN_TRY_ASSIGN(face::GltfHead head, face::import_gltf(path));
    return std::move(head.face);
  }
  return fail(ErrorCode::unsupported, "this is no face that Mien reads", what,
              "name 'builtin', a folder with generic_neutral_mesh.obj, or a .glb, .gltf or .vrm file");
}

}  // namespace mien::builtin_face
