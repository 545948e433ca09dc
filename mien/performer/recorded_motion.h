#pragma once

#include <span>

#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// A new performance at 60 Hz that is made of recorded ones, for training: clips of 3 to 10 s, crossfaded
/// over 0.4 s, with rests between some; mirrored in half of the performances; played 0.8 to 1.25 times as
/// fast. In half of the performances the upper face (brows, lids, eyes) plays other clips than the rest.
/// Each shape's motion is scaled about its rest in the recording (its 10th percentile), and the rest is drawn
/// between that of the recording and that of `style`. The head stays at rest: with_head_motion moves it.
/// `recordings`: at least one, each of at least a second with a face. `duration_s`: at least 1.
[[nodiscard]] face::Motion perform_recorded(std::span<const face::Motion> recordings, double duration_s,
                                            const Style& style, const Random& random);

/// The weights as a mirror shows them: sides change places, jawLeft and mouthLeft with jawRight and
/// mouthRight too.
[[nodiscard]] face::BlendshapeWeights mirrored(const face::BlendshapeWeights& weights);

}  // namespace mien::performer
