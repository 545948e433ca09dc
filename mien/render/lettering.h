#pragma once

#include <string_view>

#include "mien/render/image.h"

namespace mien::render {

enum class Align { left, centre, right };

/// Writes a line of printable ASCII (other characters show as a box) with a stroked font of our own.
/// `x` and `baseline` in pixels, `size_px` the height of a capital letter's line (capitals are 0.7 of it).
/// Soft edges; what falls outside the picture is left out.
void draw_text(Image& picture, std::string_view text, float x, float baseline, float size_px, Rgb ink,
               Align align = Align::left);

/// Width of the line in pixels.
[[nodiscard]] float text_width(std::string_view text, float size_px);

}  // namespace mien::render
