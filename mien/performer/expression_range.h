#pragma once

#include <span>
#include <string>
#include <vector>

#include "mien/performer/canvas.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// One exercise of a range-of-motion take: each repetition visits its poses in turn.
struct Exercise {
  std::string name;
  std::vector<Pose> poses;  ///< One: there and back. Two or more: from one directly to the next.
  float tongue_out = 0;
  Eigen::Vector2f gaze_rad = Eigen::Vector2f::Zero();  ///< Half axes of the eyes' ellipse, rad.
};

/// All exercises: brows, lids, eyes, cheeks, nose, jaw, lips, tongue; both sides and each alone.
[[nodiscard]] std::span<const Exercise> range_exercises();

/// Fills the canvas with exercises, each slow and then fast, reshuffled after each round.
void perform_range_of_motion(Canvas& canvas, const Style& style, Random random);

}  // namespace mien::performer
