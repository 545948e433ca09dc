#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "mien/face/face.h"

namespace mien::face::gltf {

/// Lower case without separators: "Eye_Blink-Left" becomes "eyeblinkleft".
[[nodiscard]] std::string plain(std::string_view name);

/// Whether any of the words stands in a plain name.
[[nodiscard]] bool has_word(std::string_view text, std::initializer_list<std::string_view> words);

/// What a mesh or its material is called, in plain names, tells what it is made of, well enough to shade it.
[[nodiscard]] Material guess_material(const std::string& names);

/// A name from the file on one line of at most 80 bytes, without anything that a terminal would obey.
[[nodiscard]] std::string printable(std::string name);

}  // namespace mien::face::gltf
