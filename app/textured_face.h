#pragma once

#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/render/gltf_export.h"

namespace mien::app {

/// A face, laid out for the textures beside it where it has any.
struct TexturedFace {
  face::Face face;
  render::GltfTextures textures;
};

/// chosen_face(what), by its person's name (`ada` of builtin:ada), with textures as `option`, the value of
/// --textures, has them: none, 1024, 2048, or empty for 2048 of a built-in face and none of others. Errors:
/// chosen_face's, bad_usage (textures of a face that is not built in).
[[nodiscard]] Result<TexturedFace> textured_face(const std::string& what, const std::string& option,
                                                 const Progress& progress = no_progress);

}  // namespace mien::app
