#pragma once

#include <string>

#include "mien/core/error.h"
#include "mien/face/gltf/assembly.h"
#include "mien/face/gltf/binding.h"
#include "mien/face/gltf_import.h"

namespace mien::face::gltf {

/// Makes the assembly a Face: turned to frame H, in metres, shapes in one piece split into sides, eyeballs
/// and skin found. `name` is the file. Errors: malformed (its shapes move nothing).
[[nodiscard]] Result<GltfHead> finish(Assembly head, const Binding& binding, const std::string& name);

}  // namespace mien::face::gltf
