#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "mien/face/profile.h"

namespace mien::measure {

/// Of each frame the directions of the left and of the right eye, as face::OutputFrame has them.
using EyeDirections = std::array<Eigen::Vector2f, 2>;

/// One stretch of frames at 60 Hz without a gap. Shape: all of equal size.
struct Stretch {
  std::span<const face::BlendshapeWeights> truth;
  std::span<const face::BlendshapeWeights> estimate;
  std::span<const EyeDirections> gaze_rad = {};  ///< The estimate's; empty: as its eyeLook weights say.
};

}  // namespace mien::measure
