#include "mien/face/gaze_targets.h"

#include <array>

namespace mien::face {
namespace {

constexpr float kAside_rad = 0.2618F, kUp_rad = 0.1745F;  // 15 and 10 degrees.

}  // namespace

std::span<const GazeTarget> gaze_targets() {
  static const std::array<GazeTarget, 5> kTargets = {
      {{"look ahead", "Keep your head still and look straight ahead", Eigen::Vector2f(0, 0)},
       {"look left", "Keep your head still and look 15 degrees to the left", Eigen::Vector2f(kAside_rad, 0)},
       {"look right", "Keep your head still and look 15 degrees to the right",
        Eigen::Vector2f(-kAside_rad, 0)},
       {"look up", "Keep your head still and look 10 degrees up", Eigen::Vector2f(0, kUp_rad)},
       {"look down", "Keep your head still and look 10 degrees down", Eigen::Vector2f(0, -kUp_rad)}}};
  return kTargets;
}

}  // namespace mien::face
