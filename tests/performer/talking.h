#pragma once

#include <cmath>
#include <numbers>

#include "mien/core/rotation.h"
#include "mien/face/motion.h"

namespace mien::performer::test {

/// `frames` at 60 Hz: the jaw opens and closes, a smile comes and goes, the head nods.
inline face::Motion talking(int frames, bool moves_head = true) {
  face::Motion motion;
  motion.name = "talking";
  motion.has_head = moves_head;
  for (int f = 0; f < frames; ++f) {
    face::MotionFrame frame;
    frame.time_s = f / 60.0;
    const double turn = 2 * std::numbers::pi * frame.time_s;
    frame.weights[face::shape("jawOpen")] = static_cast<float>(0.5 - 0.5 * std::cos(1.5 * turn));
    frame.weights[face::shape("mouthSmile_L")] = static_cast<float>(0.5 - 0.5 * std::cos(0.7 * turn));
    if (moves_head) frame.head = exp_rotation(Vec3(0.3 * std::sin(0.5 * turn), 0, 0));
    motion.frames.push_back(frame);
  }
  return motion;
}

}  // namespace mien::performer::test
