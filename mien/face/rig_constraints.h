#pragma once

#include <span>

#include "mien/face/profile.h"

namespace mien::face {

/// What a pair of shapes does to each other: rules that faces keep and least squares does not know.
struct ShapeRule {
  enum class Kind {
    exclusive,  ///< Never both: muscles that pull against each other.
    together,   ///< As a rule alike: what is seen of one says what the other does.
    at_most,    ///< `a` is never above `b`: a corrective, which alone would tear the mesh.
  };
  Kind kind = Kind::exclusive;
  std::size_t a = 0;  ///< Index in kShapeNames.
  std::size_t b = 0;
};

/// What holds of faces in general: jaw and mouth go one way at a time, lids do not widen while they close,
/// both lids blink together, the lips close only what the jaw opens.
[[nodiscard]] std::span<const ShapeRule> natural_rules();

}  // namespace mien::face
