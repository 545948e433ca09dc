#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/face/profile.h"

namespace mien::face {

/// A corrective blendshape (combination shape): what a pose of several shapes adds to their sum, so that skin
/// meets skin where the sum would go through it. For pictures alone: metrics, skin sites and exported files
/// stay linear in the weights.
struct Corrective {
  /// How a shape's weight w drives it: clamp(w, from, until) - from.
  struct Driver {
    std::size_t shape = 0;  ///< Index of kShapeNames.
    float from = 0;
    float until = 1;
  };
  std::vector<Driver> drivers;        ///< Their values are multiplied.
  std::vector<std::uint32_t> vertex;  ///< Ascending.
  std::vector<Vec3f> delta_m;         ///< Displacement where that product is 1, metres; beside `vertex`.
};

/// Adds to M(w) what these say, before eyeballs turn. Every `vertex` is within vertices_m. No allocation.
void add_correctives(std::span<const Corrective> correctives, const BlendshapeWeights& weights,
                     std::span<Vec3f> vertices_m);

}  // namespace mien::face
