#include "mien/performer/encore.h"

#include <algorithm>
#include <cmath>

#include "mien/core/time.h"
#include "mien/performer/canvas.h"

namespace mien::performer {
face::MotionFrame Encore::at(const face::MotionCurve& motion, double time_s) const {
  const double round_s = end_s - begin_s;
  if (time_s < end_s || !(round_s > 0)) return motion.at(time_s);
  const double rounds = std::floor((time_s - begin_s) / round_s);
  face::MotionFrame frame = motion.at(time_s - rounds * round_s);
  frame.head_position_m += rounds * walked_m;
  return frame;
}

Encore add_encore(PrologueMotion& motion) {
  const face::MotionCurve curve(motion.motion);
  const double begin_s = motion.times.motion_start_s;
  const double last_s = curve.duration_s();
  const face::MotionFrame first = curve.at(begin_s);
  const face::MotionFrame last = curve.at(last_s);
  constexpr double kStepS = 1 / kFrameRateHz;
  const Vec3 speed_m_s =
      (last.head_position_m - curve.at(std::max(begin_s, last_s - kStepS)).head_position_m) / kStepS;

  const auto steps = static_cast<int>(std::lround(kReturnS * kFrameRateHz));
  Vec3 position_m = last.head_position_m;
  for (int i = 1; i <= steps; ++i) {
    const double ease = minimum_jerk(static_cast<double>(i) / steps);
    face::MotionFrame frame;
    frame.time_s = last_s + i * kStepS;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      frame.weights[k] = last.weights[k] + static_cast<float>(ease) * (first.weights[k] - last.weights[k]);
    frame.tongue_out = last.tongue_out + static_cast<float>(ease) * (first.tongue_out - last.tongue_out);
    frame.head = last.head.slerp(ease, first.head);
    position_m += (1 - ease) * kStepS * speed_m_s;
    frame.head_position_m = position_m;
    motion.motion.frames.push_back(frame);
  }
  return {begin_s, last_s + kReturnS, position_m - first.head_position_m};
}

void repeat(PrologueMotion& motion, const Encore& encore, double duration_s) {
  std::vector<face::MotionFrame>& frames = motion.motion.frames;
  const auto after = [&](double time_s) {
    return std::ranges::upper_bound(frames, time_s, {}, &face::MotionFrame::time_s) - frames.begin();
  };
  const std::ptrdiff_t begin = after(encore.begin_s), end = std::ssize(frames);
  const double round_s = encore.end_s - encore.begin_s;
  for (double rounds = 1; begin < end && encore.begin_s + rounds * round_s < duration_s; ++rounds)
    for (std::ptrdiff_t f = begin; f < end; ++f) {
      face::MotionFrame frame = frames[static_cast<std::size_t>(f)];
      frame.time_s += rounds * round_s;
      frame.head_position_m += rounds * encore.walked_m;
      frames.push_back(frame);
    }
  frames.resize(static_cast<std::size_t>(after(duration_s)));
}

}  // namespace mien::performer
