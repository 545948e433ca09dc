#pragma once

#include "mien/face/output_frame.h"
#include "mien/face/profile.h"

namespace mien::shaping {

/// face::kEyeTurnRadPerUnit in single precision, as eye directions are.
inline constexpr auto kEyeTurnRad = static_cast<float>(face::kEyeTurnRadPerUnit);
/// Confidence factor: skin sensors hardly observe gaze.
inline constexpr float kGazeConfidence = 0.2f;

/// Derives eye directions from the eyeLook weights where no tracker gave them (provenance neutral and
/// confidence 0): yaw and pitch, kEyeTurnRad per unit weight. Confidence: kGazeConfidence times those shapes'
/// mean. Provenance: predicted, or the shapes' own where that is held, audio or neutral. No allocation.
/// Thread-safe.
void eyes_from_weights(face::OutputFrame& frame);

}  // namespace mien::shaping
