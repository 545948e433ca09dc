#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace mien::shaping {

/// The steps between trackers and sinks, in the one order in which they act (docs/method/shaping.md).
enum class ChainStep : std::uint8_t {
  mend,         ///< Invalid values are replaced (mend()).
  merge,        ///< Several trackers' frames become one (Merge); without it the first of the rig's answers.
  fallback,     ///< Lost sensors are bridged (Fallback).
  resting,      ///< The face at rest is learnt and taken off (Resting).
  recentring,   ///< The centre is taken off (Recentre).
  blinks,       ///< Lids that no sensor observes blink (Blinks).
  gains,        ///< Gains and limits of each shape (Limits).
  smoothing,    ///< One Euro (Smoothing).
  constraints,  ///< What faces cannot do (face::RigConstraints).
  bounds,       ///< [0, 1], and no step above kStepAtMost (bounds.h).
  gaze,         ///< Lids from eye directions, and directions from lids (Lids, eyes_from_weights()).
};
inline constexpr std::size_t kChainStepCount = 11;
/// "mend", ..., "gaze": in the order of ChainStep.
inline constexpr std::array<std::string_view, kChainStepCount> kChainStepNames = {
    "mend",  "merge",     "fallback",    "resting", "recentring", "blinks",
    "gains", "smoothing", "constraints", "bounds",  "gaze"};

/// Some of them, by their number.
using ChainSteps = std::bitset<kChainStepCount>;

}  // namespace mien::shaping
