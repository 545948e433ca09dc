#pragma once

#include <string>

#include "mien/core/time.h"
#include "mien/face/profile.h"

namespace mien::tracker {

/// An expression that a wearer was asked for, as a take's event "prompt" tells it. What was done is not
/// known: it comes late, stronger or weaker than asked, and with something of other shapes.
struct PromptedExpression {
  std::string name;
  DeviceTime begin, end;  ///< Asked for from begin to end.
  double rise_s = 0.4;    ///< How long the way there and back takes.
  /// Shown until its end, as mien record shows it; else to be left so early that the face rests at the end,
  /// as a virtual performer's prologue wants it.
  bool held = false;
  face::BlendshapeWeights target;
};

/// So late, s, people still do what they were asked for.
inline constexpr double kLatestAnswer_s = 0.6;

}  // namespace mien::tracker
