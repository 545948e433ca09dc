#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/face/face.h"

namespace mien::render {

/// One hair of a ribbon at a place of it.
struct Strand {
  float cover = 0;       ///< How much of the place is hair, 0 to 1.
  float brightness = 1;  ///< Factor on the hair's colour, 0.75 to 1.25.
};

/// The hairs of face::Material::strands at `uv`: each begins a little after the root, wavers, thins and ends
/// before the ribbon's tip. `softness`: half the width of a hair's edge, in hairs; larger where a pixel is
/// wider. The same at every whole unit of uv.x.
[[nodiscard]] Strand strand_at(const Eigen::Vector2f& uv, float softness);

/// One unit of uv.x of them as a picture with alpha, a PNG file's content; rows from uv.y 0 to 1. White is
/// face::kBrightestStrand times the hair's colour.
[[nodiscard]] Result<std::vector<std::byte>> strands_png();

/// Hair takes light as the shape does that all of it has together, and a ribbon's two sides are alike: turns
/// the normals of strands (unit, beside `vertices_m`) towards the outside of the head.
void round_hair(std::span<const Vec3f> vertices_m, const std::vector<bool>& is_strand, const Vec3f& middle_m,
                std::span<Vec3f> normals);

/// The mean of the corners of what is not hair: inside the head.
[[nodiscard]] Vec3f middle_of_head_m(const face::Face& face);

}  // namespace mien::render
