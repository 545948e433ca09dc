#pragma once

#include <span>

#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/face/profile.h"

namespace mien::performer {

/// An expression on the screen that a performer is to make, from begin_s until the next one's.
struct PoseCue {
  double begin_s = 0;
  face::BlendshapeWeights target;
};

/// How people miss what they are shown; the defaults are those of a guided calibration's prompts.
struct Mimicry {
  double least_gain = 0.6;  ///< Each shape of each pose comes this strongly, uniform.
  double most_gain = 1.2;
  double least_late_s = 0.15;  ///< The face sets off this much after the screen.
  double most_late_s = 0.6;
  double least_ease_s = 0.4;  ///< How long it takes to get there.
  double most_ease_s = 0.9;
  int most_unasked = 3;        ///< One to this many shapes that nobody asked for, ...
  double unasked = 0.3;        ///< ... each at up to this.
  double slackening = 0.15;    ///< A held pose loses up to this share in three seconds.
  double tremor = 0.006;       ///< Standard deviation of every held shape's unrest.
  double blinks_per_min = 14;  ///< 0: none.
};

/// The performance of somebody who follows cues: 60 frames a second from 0 to `end_s`, within what a face can
/// do (performer_limits.h), neutral until the first cue. Cues by time. What is performed is the truth; only
/// what was meant is another thing. The same random state gives the same bits.
[[nodiscard]] face::Motion mimic(std::span<const PoseCue> cues, double end_s, const Mimicry& mimicry,
                                 const Random& random);

}  // namespace mien::performer
