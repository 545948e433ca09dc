#pragma once

#include <array>
#include <string_view>

#include "mien/face/shape_region.h"

namespace mien::face {

/// As files and messages name the regions, in the order of ShapeRegion.
inline constexpr std::array<std::string_view, kShapeRegionCount> kShapeRegionNames = {
    "brows", "eyes", "cheeks", "mouth", "jaw"};

}  // namespace mien::face
