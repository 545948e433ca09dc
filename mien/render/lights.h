#pragma once

#include <span>
#include <string>
#include <string_view>

#include "mien/render/renderer.h"

namespace mien::render {

/// Lights that have a name, as people choose them.
struct NamedLight {
  std::string name;
  std::string description;  ///< A line for people.
  Look look;
};

/// studio, soft, evening, infrared. Which they are: lights.toml.
[[nodiscard]] std::span<const NamedLight> named_lights();

/// The one of that name.
[[nodiscard]] const NamedLight* find_light(std::string_view name);

}  // namespace mien::render
