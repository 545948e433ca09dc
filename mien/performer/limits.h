#pragma once

#include "mien/face/profile.h"

namespace mien::performer {

/// Largest weight that a virtual performer reaches.
inline constexpr float kLargestWeight = 1.1F;

/// Soft clipping: the identity from 0 to 0.9, above it smoothly saturating at kLargestWeight; 0 below 0.
[[nodiscard]] float soft_ceiling(float weight);

/// Constrains one frame to what a face can do: weights in [0, kLargestWeight]; opposites cancel; no wide and
/// shut eyes; no cheekPuff or pressed lips over an open mouth; mouthClose <= jawOpen. `lip_closure`, 0 to 1:
/// at 1 the lips meet (mouthClose = jawOpen). Continuous in its arguments. Leaves the eyeLook weights.
void apply_limits(face::BlendshapeWeights& weights, float lip_closure);

}  // namespace mien::performer
