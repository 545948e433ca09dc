#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "mien/performer/canvas.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// One exercise of a range-of-motion take: its poses are visited in turn, once a repetition.
struct Exercise {
  std::string_view name;
  std::vector<Pose> poses;  ///< One: out and back. Two or more: from one straight to the next.
  float tongue_out = 0;
  Eigen::Vector2f gaze_rad = Eigen::Vector2f::Zero();  ///< Of the eyes' circle; half axes.
};

/// Brows, lids, eyes, cheeks, nose, jaw, lips, tongue; both sides and each alone.
[[nodiscard]] std::span<const Exercise> range_exercises();

/// Adds exercises, each slowly and then fast, shuffled anew when all have been done.
void perform_range_of_motion(Canvas& canvas, const Style& style, Random random);

}  // namespace mien::performer
