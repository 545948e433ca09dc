#pragma once

#include "mien/face/motion.h"
#include "mien/performer/prologue.h"

namespace mien::performer {

/// A performance that goes on: after `end_s` comes what came after `begin_s`, again and again. Made by
/// add_encore(), so that the seam is none for face and head.
struct Encore {
  double begin_s = 0;
  double end_s = 0;
  Vec3 walked_m = Vec3::Zero();  ///< How far each round has carried the head.

  /// The motion at any time, however late; `time_s` of what it gives is within the first round.
  [[nodiscard]] face::MotionFrame at(const face::MotionCurve& motion, double time_s) const;
};

/// Appends a second in which face and head come back to the motion's first frame (not the prologue's) and
/// whoever walks comes to a halt, and says what to repeat.
[[nodiscard]] Encore add_encore(PrologueMotion& motion);

}  // namespace mien::performer
