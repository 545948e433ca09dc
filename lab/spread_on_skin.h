#pragma once

#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::lab {

/// How far a value that is known at points of the skin reaches over it.
struct SkinSpread {
  double reach_m = 0.03;   ///< Skin farther than this from every point keeps 0 ...
  double fade_m = 0.015;   ///< ... and this far before it begins to fall towards it.
  double sharp_m = 0.004;  ///< Nearer than this a point is all that counts.
};

/// Values of points as values of the neutral face's vertices, for a picture: the points' by the fourth power
/// of how near they are. Shape: `values` beside `points_m` (frame H), at least one; the result beside the
/// vertices.
[[nodiscard]] std::vector<float> spread_on_skin(const face::Face& face, std::span<const Vec3> points_m,
                                                std::span<const double> values,
                                                const SkinSpread& spread = {});

}  // namespace mien::lab
