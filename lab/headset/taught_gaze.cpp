#include "lab/headset/taught_gaze.h"

#include "mien/performer/gaze_points.h"

namespace mien::lab {
namespace {

/// Shorter than a session asks for (session::Guide), since each frame is rendered; who performs it reads
/// nothing.
constexpr double kEach_s = 1.5, kRestsFrom_s = 0.7;
static_assert(kEach_s * 5 == kTaughtGaze_s);

}  // namespace

face::Motion gaze_targets_motion(const Random& random) {
  face::Motion motion;
  motion.name = "gaze targets";
  for (const face::BlendshapeWeights& weights :
       performer::look_at_targets(face::gaze_targets(), kEach_s, random)) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = to_seconds(frame_offset(static_cast<std::int64_t>(motion.frames.size()) - 1));
    frame.weights = weights;
  }
  return motion;
}

void guide_gaze_targets(DeviceTime begin, tracker::Tracker& tracker) {
  for (const face::GazeTarget& target : face::gaze_targets()) {
    const DeviceTime end = begin + from_seconds(kEach_s);
    tracker.guide_gaze(target, begin + from_seconds(kRestsFrom_s), end);
    begin = end;
  }
}

}  // namespace mien::lab
