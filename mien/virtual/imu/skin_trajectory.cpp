#include "mien/virtual/imu/skin_trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace mien::virt {

SkinTracer::SkinTracer(MotionAt motion, const std::vector<SkinSite>& sites, double begin_s, double end_s)
    : motion_(std::move(motion)),
      sites_(sites),
      begin_s_(begin_s),
      points_(std::isinf(end_s)
                  ? std::numeric_limits<std::size_t>::max()
                  : static_cast<std::size_t>(std::ceil((end_s - begin_s) * kTrajectoryRateHz)) + 1) {}

double SkinTracer::traced_s() const {
  return begin_s_ + (static_cast<double>(next_) - 1) / kTrajectoryRateHz;
}

SkinTrajectory SkinTracer::next(std::size_t points) {
  SkinTrajectory out;
  out.begin_s = begin_s_;
  out.first = next_;
  out.points = std::min(points, points_ - next_);
  out.head.resize(out.points);
  out.head_position_m.resize(out.points);
  out.rotation.assign(sites_.size(), std::vector<Quat>(out.points));
  out.position_m.assign(sites_.size(), std::vector<Vec3>(out.points));
  for (std::size_t i = 0; i < out.points; ++i, ++next_) {
    const double time_s = begin_s_ + static_cast<double>(next_) / kTrajectoryRateHz;
    const face::MotionFrame frame = motion_(time_s);
    out.head[i] = frame.head;
    out.head_position_m[i] = frame.head_position_m;
    for (std::size_t s = 0; s < sites_.size(); ++s) {
      out.rotation[s][i] = sites_[s].rotation(frame.weights);
      out.position_m[s][i] = sites_[s].position(frame.weights);
    }
  }
  return out;
}

SkinTrajectory trace_skin(const face::MotionCurve& motion, const std::vector<SkinSite>& sites, double begin_s,
                          double end_s) {
  return SkinTracer([&](double time_s) { return motion.at(time_s); }, sites, begin_s, end_s)
      .next(std::numeric_limits<std::size_t>::max());
}

}  // namespace mien::virt
