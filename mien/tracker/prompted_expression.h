#pragma once

#include <string>

#include "mien/core/time.h"
#include "mien/face/profile.h"

namespace mien::tracker {

/// An expression that a wearer was asked for (a take's event "prompt"). What was performed is unknown:
/// usually later, stronger or weaker than asked, and with other shapes.
struct PromptedExpression {
  std::string name;
  DeviceTime begin, end;  ///< Asked for in [begin, end), reference sensor's clock.
  double rise_s = 0.4;    ///< Duration of the way there, and of the way back.
  /// True: shown until its end (mien record). False: to be left early enough to rest at its end (a virtual
  /// performer's prologue).
  bool held = false;
  face::BlendshapeWeights target;  ///< Weights asked for, 0 to 1; 0: not asked for.
};

/// Longest latency of people's answers to a prompt, s.
inline constexpr double kLatestAnswer_s = 0.6;

}  // namespace mien::tracker
