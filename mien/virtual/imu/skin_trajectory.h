#pragma once

#include <functional>
#include <vector>

#include "mien/face/motion.h"
#include "mien/virtual/imu/skin_site.h"

namespace mien::virt {

/// Rate of the grid on which the skin's motion is computed before each sensor samples it at its own times.
inline constexpr double kTrajectoryRateHz = 240.0;

/// Where the skin under every sensor is, and how it is turned, for a whole motion or a stretch of it. True
/// time, in seconds from the session's start, which is also the motion's.
struct SkinTrajectory {
  double begin_s = 0;      ///< Time of the whole motion's first grid point.
  std::size_t first = 0;   ///< Grid points of the whole before this stretch's.
  std::size_t points = 0;  ///< Grid points here.
  std::vector<Quat> head;  ///< q_world_head; one a grid point.
  std::vector<Vec3> head_position_m;
  std::vector<std::vector<Quat>> rotation;    ///< E (head frame), per site and grid point.
  std::vector<std::vector<Vec3>> position_m;  ///< Patch centroid (head frame), per site and grid point.
};

/// Traces a motion stretch by stretch. Whatever the stretches' lengths, their points are the same. Lifetime:
/// looks at the sites.
class SkinTracer {
 public:
  /// The motion at a time, s; asked for in ascending order.
  using MotionAt = std::function<face::MotionFrame(double time_s)>;
  /// From `begin_s` to `end_s`, which may be infinite.
  SkinTracer(MotionAt motion, const std::vector<SkinSite>& sites, double begin_s, double end_s);

  [[nodiscard]] bool done() const { return next_ >= points_; }
  /// True time up to which the skin has been traced, s.
  [[nodiscard]] double traced_s() const;
  /// The next stretch: `points` of the grid, or what is left.
  [[nodiscard]] SkinTrajectory next(std::size_t points);

 private:
  MotionAt motion_;
  const std::vector<SkinSite>& sites_;
  double begin_s_;
  std::size_t points_;
  std::size_t next_ = 0;
};

/// The motion from `begin_s` to `end_s` on these sites, at once.
[[nodiscard]] SkinTrajectory trace_skin(const face::MotionCurve& motion, const std::vector<SkinSite>& sites,
                                        double begin_s, double end_s);

}  // namespace mien::virt
