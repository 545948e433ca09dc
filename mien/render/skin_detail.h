#pragma once

#include "mien/core/rotation.h"

/// What is small on skin, as functions of a place of the neutral: it moves with the skin. A pixel that shows
/// `footprint_m` of it gets the mean of dots that are finer; of finer pores nothing, which tilt and darken by
/// 1 % on average.
namespace mien::render {

/// The normal where pores tilt the surface; `bump` 0 leaves it as it is, 1 is skin's.
[[nodiscard]] Vec3f with_pores(const Vec3f& normal, const Vec3f& neutral_m, float bump, float footprint_m);

/// Factor on the albedo: pores lie in their own shade.
[[nodiscard]] float pore_shade(const Vec3f& neutral_m, float footprint_m);

/// How much of a freckle is here, 0 to 1. `amount`: 0 none to 1, where every second place has one. `person`
/// moves them.
[[nodiscard]] float freckle_cover(const Vec3f& neutral_m, float person, float amount, float footprint_m);

/// How much of the skin is roots of shaved hair, 0 to 1; `amount` as face::SkinMarks says.
[[nodiscard]] float stubble_cover(const Vec3f& neutral_m, float person, float amount, float footprint_m);

}  // namespace mien::render
