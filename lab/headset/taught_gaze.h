#pragma once

#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/face/motion.h"
#include "mien/tracker/tracker.h"

namespace mien::lab {

/// A wearer who looks at the targets of a calibration of gaze, one after the other, as a virtual performer
/// does (performer::look_at_targets): kTaughtGaze_s, at 60 Hz from 0 on.
inline constexpr double kTaughtGaze_s = 7.5;
[[nodiscard]] face::Motion gaze_targets_motion(const Random& random);
/// Tells a tracker that they are looked at from `begin` on.
void guide_gaze_targets(DeviceTime begin, tracker::Tracker& tracker);

}  // namespace mien::lab
