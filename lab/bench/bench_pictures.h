#pragma once

#include <cstdint>

#include "mien/core/error.h"

namespace mien::lab {

/// How quickly a virtual headset's pictures are made, on one thread: views of 96 x 96 pixels at four samples
/// a pixel.
struct PictureFigures {
  double pictures_per_s = 0;  ///< Of a moving face, everything included: pose, light, views, lens and sensor.
  /// How many times as quick a view is drawn as by a ray through each sample, one after the other; light and
  /// shading alike.
  double vs_single_rays = 0;
};

/// Errors: those of the default headset rig and its wearer.
[[nodiscard]] Result<PictureFigures> measure_pictures(std::uint64_t seed);

}  // namespace mien::lab
