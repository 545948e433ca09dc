#pragma once

#include "mien/face/output_frame.h"
#include "mien/face/profile.h"

namespace mien::shaping {

/// face::kEyeTurnRadPerUnit in single precision, as eye directions are.
inline constexpr auto kEyeTurnRad = static_cast<float>(face::kEyeTurnRadPerUnit);
/// Skin sensors hardly feel where the eyes look.
inline constexpr float kGazeConfidence = 0.2f;

/// Where no tracker gave eye directions (provenance neutral and confidence 0), takes them from the eyeLook
/// weights: yaw and pitch are kEyeTurnRad a unit. Confidence is kGazeConfidence of those shapes' mean;
/// provenance predicted, or what those shapes are where they are held, from audio, or neutral.
/// No allocation. Thread-safe.
void eyes_from_weights(face::OutputFrame& frame);

}  // namespace mien::shaping
