#include "mien/virtual/skin_trajectory.h"

#include <cmath>

namespace mien::virt {

SkinTrajectory trace_skin(const face::MotionCurve& motion, const std::vector<SkinSite>& sites, double begin_s,
                          double end_s) {
  SkinTrajectory out;
  out.begin_s = begin_s;
  out.points = static_cast<std::size_t>(std::ceil((end_s - begin_s) * kTrajectoryRateHz)) + 1;
  out.head.resize(out.points);
  out.head_position_m.resize(out.points);
  out.rotation.assign(sites.size(), std::vector<Quat>(out.points));
  out.position_m.assign(sites.size(), std::vector<Vec3>(out.points));
  for (std::size_t i = 0; i < out.points; ++i) {
    const face::MotionFrame frame = motion.at(begin_s + static_cast<double>(i) / kTrajectoryRateHz);
    out.head[i] = frame.head;
    out.head_position_m[i] = frame.head_position_m;
    for (std::size_t s = 0; s < sites.size(); ++s) {
      out.rotation[s][i] = sites[s].rotation(frame.weights);
      out.position_m[s][i] = sites[s].position(frame.weights);
    }
  }
  return out;
}

}  // namespace mien::virt
