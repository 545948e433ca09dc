#pragma once

#include <span>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/gaze_targets.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// A performer who is asked to look at targets one after the other, each for `each_s`, and does nothing else:
/// weights at 60 Hz. The eyes turn 0.2 to 0.5 s after they are asked to, come to rest half a degree off (one
/// sigma either way), drift there, and the lids blink.
[[nodiscard]] std::vector<face::BlendshapeWeights> look_at_targets(std::span<const face::GazeTarget> targets,
                                                                   double each_s, const Random& random);

}  // namespace mien::performer
