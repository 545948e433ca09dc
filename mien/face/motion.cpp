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
    if (frame.has_face || motion.head_without_face)
      heads_.push_back({frame.time_s, frame.head, frame.head_position_m});
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

void MotionCurve::put_head(double time_s, MotionFrame& out) const {
  const auto after = std::ranges::upper_bound(heads_, time_s, {}, &Head::time_s);
  if (after == heads_.begin() || after == heads_.end()) {
    const Head& end = after == heads_.begin() ? heads_.front() : heads_.back();
    out.head = end.orientation;
    out.head_position_m = end.position_m;
    return;
  }
  const auto d = after + 1 < heads_.end() ? after + 1 : after;
  const auto b = after - 1;
  const auto a = b > heads_.begin() ? b - 1 : b;
  const double span_s = after->time_s - b->time_s;
  // At the ends there is no fourth point: the third stands twice, at an even distance.
  const KnotSpacing spacing{.before = a < b ? (b->time_s - a->time_s) / span_s : 1.0,
                            .after = d > after ? (d->time_s - after->time_s) / span_s : 1.0};
  const double u = (time_s - b->time_s) / span_s;
  out.head =
      interpolate_rotation(a->orientation, b->orientation, after->orientation, d->orientation, u, spacing);
  out.head_position_m =
      interpolate_point(a->position_m, b->position_m, after->position_m, d->position_m, u, spacing);
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
  }
  put_head(time_s, out);
  out.time_s = time_s;
  out.has_face = std::ranges::none_of(
      lost_s_, [&](const auto& gap) { return time_s > gap.first && time_s < gap.second; });
  return out;
}

}  // namespace mien::face
