#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

namespace mien::face {

/// A point that a calibration of gaze asks to look at, so that what is found there can be compared with what
/// is so.
struct GazeTarget {
  std::string_view name;          ///< "look left".
  std::string_view prompt;        ///< "Keep your head still and look 15 degrees to the left".
  Eigen::Vector2f direction_rad;  ///< As OutputFrame::eyes_rad: yaw to the performer's left, pitch upwards.
};

/// Ahead, left, right, up, down, in the order in which they are asked for: far enough apart to tell a gain,
/// near enough for a screen and for lids.
[[nodiscard]] std::span<const GazeTarget> gaze_targets();

}  // namespace mien::face
