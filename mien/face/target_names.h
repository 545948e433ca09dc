#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace mien::face {

/// The shapes that a morph target's name stands for: "jawOpen", "eyeBlinkLeft", "EyeBlink_L",
/// "eye_blink_left", "Face.eyeBlink_L" and ICT's own. Indices as in Face::shapes (kShapeCount is tongueOut);
/// browInnerUp and cheekPuff give both sides. Empty when it is none of them.
[[nodiscard]] std::vector<std::size_t> shapes_of_name(std::string_view name);

/// The shape of that name; both sides, the left first, of a pair whose name it is without "_L" and "_R"; none
/// for any other name.
[[nodiscard]] std::vector<std::size_t> shapes_named(std::string_view name);

}  // namespace mien::face
