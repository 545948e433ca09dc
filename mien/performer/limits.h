#pragma once

#include "mien/face/profile.h"

namespace mien::performer {

/// Largest weight that a virtual performer reaches.
inline constexpr float kLargestWeight = 1.1F;

/// The identity up to 0.9, from there bent smoothly towards kLargestWeight; 0 below 0.
[[nodiscard]] float soft_ceiling(float weight);

/// Holds one frame to what a face (and a tracker that has seen many) can do: weights in [0, kLargestWeight];
/// opposites not together; eyes not wide and shut; cheeks and lips not full over a mouth that gapes;
/// mouthClose <= jawOpen. `lip_closure` 1 brings the lips together whatever else is asked: mouthClose =
/// jawOpen. Continuous in its arguments. The eyeLook weights are left alone.
void apply_limits(face::BlendshapeWeights& weights, float lip_closure);

}  // namespace mien::performer
