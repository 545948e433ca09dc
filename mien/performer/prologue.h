#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/random.h"
#include "mien/face/motion.h"

namespace mien::performer {

/// Calibration prologue of a performance.
enum class PrologueKind {
  none,
  brief,   ///< "short": neutral, nod, shake.
  full,    ///< The same, then anchor expressions and a minute of prompted range of motion.
  guided,  ///< "full", with the timing of a live session's guidance.
  gaze,    ///< "short", then the targets of a calibration of gaze, with that
           ///< timing too.
};
/// By the numbers of PrologueKind: as options and takes name them.
inline constexpr std::array<std::string_view, 5> kPrologueNames = {"none", "short", "full", "guided", "gaze"};
/// brief for a name that is none.
[[nodiscard]] PrologueKind prologue_kind(std::string_view name);

/// Seconds from the start of the whole; end_s == begin_s: none.
struct Interval {
  double begin_s = 0;
  double end_s = 0;
};

/// What the performer was asked for, which a tracker may use. The motion is what was performed.
struct Prompt {
  std::string name;     ///< "jawOpen", "smile", ...
  bool anchor = false;  ///< An anchor expression, held; else range of motion.
  /// As asked: begun at begin_s, reached after rise_s, left rise_s before end_s.
  double begin_s = 0;
  double end_s = 0;
  double rise_s = 0.4;
  face::BlendshapeWeights target;
};

/// A target of a calibration of gaze is asked for so long.
inline constexpr double kGazeTarget_s = 2.7;

/// Times of the prologue's parts.
struct PrologueTimes {
  Interval neutral;  ///< w = 0 exactly; the head upright with postural sway.
  Interval nod;      ///< Two cycles of about +-20 degrees, downwards first; w = 0.
  Interval shake;    ///< Two cycles of about +-20 degrees; w = 0.
  Interval anchors;
  Interval range_of_motion;
  Interval gaze;                ///< Targets are looked at, each for kGazeTarget_s.
  Interval ease;                ///< Half a second from neutral into the motion's first frame; not evaluated.
  double motion_start_s = 0;    ///< New time of the motion's time 0.
  std::vector<Prompt> prompts;  ///< Of a full prologue, in order.
};

struct PrologueMotion {
  face::Motion motion;  ///< Prologue at 60 Hz, then the given motion, its time code moved by motion_start_s.
  PrologueTimes times;
};

/// Requirements of the sensors.
struct PrologueNeeds {
  double neutral_s = 3;  ///< Duration of the neutral hold, s. Raising: a steadier neutral, a longer prologue.
  /// False: no nod and shake, and the head held upright (profile "lab").
  bool gestures = true;
};
/// Glasses: skin folds last about a second, so ten seconds determine the median; gestures give no
/// information.
inline constexpr PrologueNeeds kEyewearPrologue = {.neutral_s = 10, .gestures = false};

/// 1 for each shape that a full prologue asks for, alone or with others; 0 for the rest.
[[nodiscard]] face::BlendshapeWeights prompted_shapes();

/// Prepends a calibration prologue to a motion. In a full one the performance deviates from every prompt:
/// gain 0.6 to 1.2 a shape, 0.15 to 0.6 s late, one to three unasked shapes of up to 0.3, asymmetry.
[[nodiscard]] PrologueMotion with_prologue(const face::Motion& motion, PrologueKind kind,
                                           const Random& random, const PrologueNeeds& needs = {});

}  // namespace mien::performer
