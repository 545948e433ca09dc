#pragma once

#include <filesystem>
#include <string>

#include "app/command_line.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/render/gltf_export.h"

namespace mien::app {

/// --names: by whose names a receiver finds the morph targets of a glTF asset; empty until it is given.
Option add_names_option(Command command, std::string& names);

/// --textures: the side of the pictures of a built-in face, or none; empty until it is given.
Option add_textures_option(Command command, std::string& textures);

/// What a value of --names means for a file: where none was given, our own names, of a .vrm VRM's.
[[nodiscard]] render::GltfNames gltf_names(const std::string& names, const std::filesystem::path& file);

/// check_output() of a file with these names, or, where they are not VRM's, with the ending `other` (".csv").
[[nodiscard]] Result<void> check_gltf_output(const std::filesystem::path& file, render::GltfNames names,
                                             const std::string& other);

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
