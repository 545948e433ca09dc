#pragma once

#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"

namespace mien::builtin_face {

/// The face that `--face` names: somebody of the built-in family (builtin_face/person.h), a folder with
/// generic_neutral_mesh.obj (or with FaceXModel in it), or a .glb, .gltf or .vrm file. Errors: those of
/// find_person, not_found, unsupported, and those of the importers.
[[nodiscard]] Result<face::Face> load_face(const std::string& what, const Progress& progress = no_progress);

}  // namespace mien::builtin_face
