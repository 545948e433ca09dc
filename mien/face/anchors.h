#pragma once

#include <span>
#include <string_view>

#include "mien/face/profile.h"

namespace mien::face {

/// An expression that a calibration asks for and that a performer can be expected to do: between them they
/// move every sensor of a face.
struct Anchor {
  std::string_view name;    ///< "smile".
  std::string_view prompt;  ///< "Smile as wide as you can".
  BlendshapeWeights target;
};

/// In the order in which they are asked for.
[[nodiscard]] std::span<const Anchor> anchors();

/// A range of motion in the same form: the shapes that a performer can be asked for one by one, both sides
/// together, some also alone. Names as the shapes', without the side where both are asked for.
[[nodiscard]] std::span<const Anchor> range_of_motion();

}  // namespace mien::face
