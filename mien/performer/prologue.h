#pragma once

#include <string>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/motion.h"

namespace mien::performer {

/// What a performance begins with.
enum class PrologueKind {
  none,
  brief,   ///< "short": neutral, nod, shake.
  full,    ///< The same, then anchor expressions and a minute of prompted range of motion.
  guided,  ///< "full", in the time in which a live session that began with it leads through it.
};

/// Seconds from the start of the whole; end_s == begin_s when there was none.
struct Interval {
  double begin_s = 0;
  double end_s = 0;
};

/// What the performer was asked to do; a tracker may know it. What was done is the motion itself.
struct Prompt {
  std::string name;     ///< "jawOpen", "smile", ...
  bool anchor = false;  ///< An anchor expression, held; else range of motion.
  /// The target is asked for from begin_s, reached (as asked) after rise_s, and to be left rise_s before
  /// end_s.
  double begin_s = 0;
  double end_s = 0;
  double rise_s = 0.4;
  face::BlendshapeWeights target;
};

/// When is what.
struct PrologueTimes {
  Interval neutral;  ///< w = 0 exactly; the head upright but for the sway of a living body.
  Interval nod;      ///< Two cycles of about +-20 degrees, downwards first; w = 0.
  Interval shake;    ///< Two cycles of about +-20 degrees; w = 0.
  Interval anchors;
  Interval range_of_motion;
  Interval ease;                ///< Half a second from neutral into the motion's first frame; not evaluated.
  double motion_start_s = 0;    ///< Where the motion's time 0 came to stand.
  std::vector<Prompt> prompts;  ///< Of a full prologue, in order.
};

struct PrologueMotion {
  face::Motion motion;  ///< Prologue at 60 Hz, then the given motion, its time code moved by motion_start_s.
  PrologueTimes times;
};

/// What the sensors ask of a prologue.
struct PrologueNeeds {
  double neutral_s = 3;
  /// False leaves out nod and shake, as the profile *lab* asks, and holds the head upright.
  bool gestures = true;
};
/// Glasses: folds of the skin come and go in a second, and ten of them tell the middle; gestures tell
/// nothing.
inline constexpr PrologueNeeds kEyewearPrologue = {.neutral_s = 10, .gestures = false};

/// The shapes that a full prologue asks for, alone or with others: 1 for each, 0 for the rest.
[[nodiscard]] face::BlendshapeWeights prompted_shapes();

/// Puts a calibration prologue before a motion. In a full prologue every prompt is
/// missed: gain 0.6 to 1.2 a shape, 0.15 to 0.6 s late, one to three shapes unasked at up to 0.3, left and
/// right unlike.
[[nodiscard]] PrologueMotion with_prologue(const face::Motion& motion, PrologueKind kind,
                                           const Random& random, const PrologueNeeds& needs = {});

}  // namespace mien::performer
