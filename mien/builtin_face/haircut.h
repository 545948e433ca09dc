#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/rotation.h"

namespace mien::builtin_face {

/// Hair of the head as ribbons of strands, on the default head; mm, frame H.
struct Haircut {
  std::vector<Vec3> p;
  std::vector<Eigen::Vector2f> uv;  ///< As face::Material::strands has it.
  std::vector<float> shade;  ///< Factor on the hair's colour: dark at roots and in the depth of the hair.
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The cut of a style, made at its first call (some hundredths of a second) and kept. Thread-safe.
[[nodiscard]] const Haircut& haircut(HairStyle style);

/// How far (mm, about) a point of the skin lies within the hairline; negative outside.
[[nodiscard]] double within_hairline(const Vec3& p);

}  // namespace mien::builtin_face
