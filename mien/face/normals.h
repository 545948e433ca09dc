#pragma once

#include <algorithm>
#include <array>

#include "mien/core/rotation.h"

namespace mien::face {

/// What a triangle adds to the normals of its corners a, b, c (counter-clockwise from outside): its own
/// direction over the squared lengths of the two edges that meet there. On a sphere their sum is exact
/// however quads are split, where weighting by area leaves ridges. Lengths in any unit; the sum is not unit.
/// Source: Max 1999, "Weights for computing vertex normals from facet normals",
/// doi:10.1080/10867651.1999.10487501.
[[nodiscard]] inline std::array<Vec3f, 3> corner_normals(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f ab = b - a, bc = c - b, ca = a - c;
  const Vec3f across = ab.cross(-ca);
  constexpr float kLeast = 1e-16F;  // Of a point's.
  const float ab2 = std::max(ab.squaredNorm(), kLeast), bc2 = std::max(bc.squaredNorm(), kLeast),
              ca2 = std::max(ca.squaredNorm(), kLeast);
  return {Vec3f(across / (ab2 * ca2)), Vec3f(across / (ab2 * bc2)), Vec3f(across / (bc2 * ca2))};
}

}  // namespace mien::face
