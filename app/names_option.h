#pragma once

#include <filesystem>
#include <string>

#include "app/command_line.h"
#include "mien/render/gltf_export.h"

namespace mien::app {

/// --names: by whose names a receiver finds the morph targets of a glTF asset; empty until it is given.
Option add_names_option(Command command, std::string& names);

/// What a value of --names means for a file: where none was given, our own names, of a .vrm VRM's.
[[nodiscard]] render::GltfNames gltf_names(const std::string& names, const std::filesystem::path& file);

}  // namespace mien::app
