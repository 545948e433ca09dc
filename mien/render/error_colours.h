#pragma once

#include "mien/core/rotation.h"
#include "mien/render/image.h"
#include "mien/render/lettering.h"

namespace mien::render {

/// The colour of an error, `fraction` 0 (pale) to 1 (dark violet): lightness falls evenly, so that it also
/// reads in grey and for the colour-blind. Linear RGB.
[[nodiscard]] Vec3f error_colour(float fraction);

/// Draws the ramp with its scale in millimetres along the bottom of a picture.
void draw_error_legend(Image& picture, const Lettering& lettering, float full_scale_m, Rgb ink);

}  // namespace mien::render
