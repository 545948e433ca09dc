#pragma once

#include <vector>

#include "mien/face/motion.h"
#include "mien/performer/prologue.h"
#include "mien/take/take.h"
#include "mien/virtual/virtual_clock.h"

// What a take of a virtual performer says of the performance itself, whatever its sensors are.
namespace mien::virt {

/// The prologue as a take's events, on the reference's clock: "neutral", "nod", "shake", "range" (all of
/// the prompts), "prompt", "ease"; steps that were left out have none.
[[nodiscard]] std::vector<take::Event> prologue_events(const performer::PrologueTimes& times,
                                                       const VirtualClock& reference);

/// What is performed at a frame's true time; evaluated from the motion's own start to its last frame.
[[nodiscard]] take::TruthFrame truth_of(const face::MotionFrame& moment, double true_s, double motion_start_s,
                                        double duration_s, DeviceTime frame);

/// Frames stand on whole nanoseconds, a motion's own times do not: nearer than this they are one moment, s.
inline constexpr double kSameMomentS = 1e-6;

}  // namespace mien::virt
