#pragma once

#include <string>

#include "app/command_line.h"
#include "mien/render/gltf_export.h"

namespace mien::app {

/// --names: by whose names a receiver finds the morph targets of a glTF asset; empty until it is given.
Option add_names_option(Command command, std::string& names);

/// What a value of --names means; empty: our own names.
[[nodiscard]] render::GltfSettings gltf_settings(const std::string& names);

}  // namespace mien::app
