#pragma once

#include "mien/face/output_frame.h"

namespace mien::shaping {

/// No eye turns further, each way: a quarter turn, rad.
inline constexpr float kEyeAtMostRad = 1.5707964f;

/// A frame at rest: weights 0, looking straight ahead, head upright; confidence 0, provenance neutral.
[[nodiscard]] face::OutputFrame neutral_frame(DeviceTime time);

/// What no tracker should give and no later step could repair: a weight, tongue, confidence, head or eye that
/// is not finite, or a head that is no rotation. Takes the value of `last` instead, with confidence 0 and
/// provenance held; brings weights and confidences into [0, 1], eyes within a quarter turn and the head to
/// unit length. Changes no bit of a frame that was well. `last` is a mended frame.
void mend(face::OutputFrame& frame, const face::OutputFrame& last);

/// What holds of every frame that leaves: weights and tongue in [0, 1], and mouthClose not above jawOpen.
/// mouthClose is a corrective of jawOpen, not "lips closed": alone it turns the lips inside out.
void bound(face::OutputFrame& frame);

/// The largest change of a weight in a 60th of a second that is shown; a blink, the fastest thing that faces
/// do, reaches 0.3 in recordings.
inline constexpr float kStepAtMost = 0.5f;

/// Holds weights and tongue within kStepAtMost a 60th of a second of `before`, the last frame that was shown:
/// what a network's or a sensor's trouble makes jump arrives a frame or two later instead. Changes no bit of
/// a frame that steps less.
void bound_steps(face::OutputFrame& frame, const face::OutputFrame& before);

}  // namespace mien::shaping
