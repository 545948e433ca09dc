#pragma once

#include "mien/face/output_frame.h"

namespace mien::shaping {

/// Largest eye yaw and pitch, each way: a quarter turn, rad.
inline constexpr float kEyeAtMostRad = 1.5707964f;
/// Largest coordinate of the head's position, each way, m: farther from where they began performers do not
/// walk before what sees them.
inline constexpr float kHeadAtMost_m = 10;

/// Replaces invalid values: a weight, tongue, confidence, head, position or eye direction that is not finite,
/// or a head that is no rotation, becomes that of `last`, with confidence 0 (that of its region too) and
/// provenance held. Clamps weights and confidences to [0, 1], eyes to kEyeAtMostRad and the head's position
/// to kHeadAtMost_m, and normalises the head; a position that is not known is 0. Changes no bit of a valid
/// frame. `last`: the previous frame, as mended.
void mend(face::OutputFrame& frame, const face::OutputFrame& last);

/// The range of every output frame: weights and tongue in [0, 1]; what is no number becomes 0.
void bound(face::OutputFrame& frame);

/// Slew-rate limit: largest change of a weight per 60th of a second. A blink, the fastest motion of a face,
/// reaches 0.3 in recordings.
inline constexpr float kStepAtMost = 0.5f;

/// Limits the change of weights and tongue from `before`, the last output frame, to kStepAtMost per 60th of a
/// second, so that faults of a network or a sensor do not show as jumps; a real one arrives a frame or two
/// later. Changes no bit of a frame that steps less.
void bound_steps(face::OutputFrame& frame, const face::OutputFrame& before);

}  // namespace mien::shaping
