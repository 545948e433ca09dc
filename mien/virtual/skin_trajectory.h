#pragma once

#include <vector>

#include "mien/face/motion.h"
#include "mien/virtual/skin_site.h"

namespace mien::virt {

/// Rate of the grid on which the skin's motion is computed before each sensor samples it at its own times.
inline constexpr double kTrajectoryRateHz = 240.0;

/// Where the skin under every sensor is, and how it is turned, for a whole motion. True time, in seconds from
/// the session's start, which is also the motion's.
struct SkinTrajectory {
  double begin_s = 0;      ///< Time of the first grid point.
  std::size_t points = 0;  ///< Grid points.
  std::vector<Quat> head;  ///< q_world_head; one a grid point.
  std::vector<Vec3> head_position_m;
  std::vector<std::vector<Quat>> rotation;    ///< E (head frame), per site and grid point.
  std::vector<std::vector<Vec3>> position_m;  ///< Patch centroid (head frame), per site and grid point.
};

/// The motion from `begin_s` to `end_s` on these sites.
[[nodiscard]] SkinTrajectory trace_skin(const face::MotionCurve& motion, const std::vector<SkinSite>& sites,
                                        double begin_s, double end_s);

}  // namespace mien::virt
