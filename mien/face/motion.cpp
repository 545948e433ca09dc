#include "mien/face/motion.h"

#include <algorithm>

#include "mien/core/monotone_cubic.h"

namespace mien::face {

MotionCurve::MotionCurve(const Motion& motion) {
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    const MotionFrame& frame = motion.frames[i];
    if (frame.has_face) {
      time_s_.push_back(frame.time_s);
      frames_.push_back(frame);
    }
  }
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    if (motion.frames[i].has_face) continue;
    const double begin = i > 0 ? motion.frames[i - 1].time_s : -1e9;
    std::size_t j = i;
    while (j < motion.frames.size() && !motion.frames[j].has_face) ++j;
    lost_s_.emplace_back(begin, j < motion.frames.size() ? motion.frames[j].time_s : 1e9);
    i = j;
  }
  const std::size_t n = frames_.size();
  slope_.resize(n);
  tongue_slope_.resize(n);
  std::vector<float> value(n);
  std::vector<float> slope(n);
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    for (std::size_t i = 0; i < n; ++i) value[i] = frames_[i].weights[k];
    monotone_slopes(time_s_, value, slope);
    for (std::size_t i = 0; i < n; ++i) slope_[i][k] = slope[i];
  }
  for (std::size_t i = 0; i < n; ++i) value[i] = frames_[i].tongue_out;
  monotone_slopes(time_s_, value, tongue_slope_);
}

MotionFrame MotionCurve::at(double time_s) const {
  MotionFrame out;
  out.time_s = time_s;
  if (frames_.empty()) {
    out.has_face = false;
    return out;
  }
  const auto after = std::ranges::upper_bound(time_s_, time_s);
  if (after == time_s_.begin()) {
    out = frames_.front();
  } else if (after == time_s_.end()) {
    out = frames_.back();
  } else {
    const auto b = static_cast<std::size_t>(after - time_s_.begin());
    const std::size_t a = b - 1;
    const double t0 = time_s_[a];
    const double t1 = time_s_[b];
    for (std::size_t k = 0; k < kShapeCount; ++k)
      out.weights[k] =
          hermite(t0, frames_[a].weights[k], slope_[a][k], t1, frames_[b].weights[k], slope_[b][k], time_s);
    out.tongue_out = hermite(t0, frames_[a].tongue_out, tongue_slope_[a], t1, frames_[b].tongue_out,
                             tongue_slope_[b], time_s);
    const double u = (time_s - t0) / (t1 - t0);
    const MotionFrame& before = frames_[a > 0 ? a - 1 : a];
    const MotionFrame& beyond = frames_[b + 1 < frames_.size() ? b + 1 : b];
    out.head = interpolate_rotation(before.head, frames_[a].head, frames_[b].head, beyond.head, u);
    out.head_position_m = interpolate_point(before.head_position_m, frames_[a].head_position_m,
                                            frames_[b].head_position_m, beyond.head_position_m, u);
  }
  out.time_s = time_s;
  out.has_face = std::ranges::none_of(
      lost_s_, [&](const auto& gap) { return time_s > gap.first && time_s < gap.second; });
  return out;
}

}  // namespace mien::face
