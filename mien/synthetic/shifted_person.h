#pragma once

#include <cstddef>

#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"

namespace mien::synthetic {

/// Someone outside the distribution that models are trained on (distribution shift).
struct ShiftedPerson {
  face::Face face;
  face::Motion motion;
};

/// A person of the built-in family and `seconds` (at least 1/60) of performance, of three kinds in turn by
/// `index`, none of which training draws:
///
/// 0. *other blocks*: a meal or the fastest motions (performer::Block::eating, rapid);
/// 1. *another neutral*: scripts of training as a capture system with another neutral reports them: three in
///    ten shapes rest at r, even from 0 to 0.4, w' = r + (1 - r) w;
/// 2. *another response*: that, and w' = r + (1 - r) w^g with g log-normal about 1 (0.5) for each shape.
///
/// Gaze, blinks and `jawOpen` keep their weights; mouthClose <= jawOpen. The face does what the motion says.
/// The distributions are assumed: capture systems differ in their neutral (Live Link takes come raw or with
/// it subtracted) and in what they call full. The same index and random state give the same bits.
[[nodiscard]] ShiftedPerson draw_shifted_person(std::size_t index, double seconds, const Random& root);

inline constexpr std::size_t kShiftKinds = 3;

}  // namespace mien::synthetic
