#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::render {

/// The hairs at a place of a ribbon.
struct Strand {
  float cover = 0;       ///< How much of the place is hair, 0 to 1.
  float brightness = 1;  ///< Factor on the hair's colour, 0.75 to 1.25; of several hairs the mean.
};

/// The hairs of face::Material::strands about `uv`: each begins a little after the root, wavers, thins and
/// ends before the ribbon's tip. Their mean over `width` hairs across the ribbon (1/16 to 32), so that a
/// pixel as wide shows neither less nor more of them wherever it lies. The same at every whole unit of uv.x.
[[nodiscard]] Strand strand_at(const Eigen::Vector2f& uv, float width);

/// One unit of uv.x of them as a picture with alpha, a PNG file's content; rows from uv.y 0 to 1. White is
/// face::kBrightestStrand times the hair's colour.
[[nodiscard]] Result<std::vector<std::byte>> strands_png();

/// Hair takes light as the shape does that all of it has together, and a ribbon's two sides are alike: the
/// normal (unit) of a place of it, turned towards the outside of the head. `middle_m`: inside the head.
[[nodiscard]] Vec3f rounded_hair(const Vec3f& p_m, const Vec3f& normal, const Vec3f& middle_m);
/// The same of all vertices that are strands.
void round_hair(std::span<const Vec3f> vertices_m, const std::vector<bool>& is_strand, const Vec3f& middle_m,
                std::span<Vec3f> normals);

/// The mean of the corners of what is not hair: inside the head.
[[nodiscard]] Vec3f middle_of_head_m(const face::Face& face);

}  // namespace mien::render
