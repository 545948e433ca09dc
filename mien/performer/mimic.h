#pragma once

#include <span>

#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// A prompted expression, from begin_s until the next cue's.
struct PoseCue {
  double begin_s = 0;
  face::BlendshapeWeights target;
};

/// Deviations of a performer from prompts. Defaults: assumed, as for prologue prompts
/// (docs/method/performer.md); not measured on people. Intervals are uniform distributions.
struct Mimicry {
  /// Gain of each shape of each pose. Raising either: stronger expressions; a wider interval: less
  /// predictable ones.
  double least_gain = 0.6;
  double most_gain = 1.2;
  /// Latency after the cue, s. Raising: later answers.
  double least_late_s = 0.15;
  double most_late_s = 0.6;
  /// Duration of the transition, s. Raising: slower movements.
  double least_ease_s = 0.4;
  double most_ease_s = 0.9;
  /// Unasked shapes of each pose: one to this many, each up to the weight below. Raising either: more
  /// deviation from the prompt. 0: none.
  int most_unasked = 3;
  double unasked = 0.3;
  /// Largest share that a held pose loses in three seconds. Raising: weaker holds.
  double slackening = 0.15;
  double tremor = 0.006;       ///< Standard deviation of a held shape, weight. Raising: noisier holds.
  double blinks_per_min = 14;  ///< Spontaneous blinks a minute; 0: none.
};

/// Motion of a performer who follows cues: 60 Hz from 0 to `end_s`, within apply_limits() (limits.h), neutral
/// until the first cue. `cues`: by rising time. The result is ground truth; the cues are what was asked for.
/// The same random state gives the same bits.
[[nodiscard]] face::Motion mimic(std::span<const PoseCue> cues, double end_s, const Mimicry& mimicry,
                                 const Random& random);

}  // namespace mien::performer
