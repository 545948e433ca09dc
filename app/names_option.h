#pragma once

#include <filesystem>
#include <string>

#include "app/command_line.h"
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

}  // namespace mien::app
