#pragma once

#include "mien/face/motion.h"
#include "mien/performer/prologue.h"

namespace mien::performer {

/// How long face and head take to return to the motion's first frame, s.
inline constexpr double kReturnS = 1;

/// An endless loop of a performance: after `end_s` it continues at `begin_s`. Made by add_encore(), without a
/// discontinuity of face and head.
struct Encore {
  double begin_s = 0;
  double end_s = 0;
  Vec3 walked_m = Vec3::Zero();  ///< Displacement of the head per round, world frame.

  /// The motion at any time >= 0; its `time_s` is within the first round.
  [[nodiscard]] face::MotionFrame at(const face::MotionCurve& motion, double time_s) const;
};

/// Appends a second in which face and head return to the motion's first frame (after the prologue) and
/// walking stops, and returns the loop.
[[nodiscard]] Encore add_encore(PrologueMotion& motion);

/// Appends the rounds of an encore that begin before `duration_s`, the whole's, and cuts the last one there.
void repeat(PrologueMotion& motion, const Encore& encore, double duration_s);

}  // namespace mien::performer
