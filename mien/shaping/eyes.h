#pragma once

#include <array>
#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/face/profile.h"

namespace mien::shaping {

/// face::kEyeTurnRadPerUnit in single precision, as eye directions are.
inline constexpr auto kEyeTurnRad = static_cast<float>(face::kEyeTurnRadPerUnit);
/// Shapes of one eye, by number: those of it turned to the performer's left, right, up and down.
struct EyeShapes {
  std::size_t left;
  std::size_t right;
  std::size_t up;
  std::size_t down;
};
/// Left eye, right eye, as face::OutputFrame::eyes_rad.
inline constexpr std::array<EyeShapes, 2> kEyeShapes = {
    EyeShapes{face::shape("eyeLookOut_L"), face::shape("eyeLookIn_L"), face::shape("eyeLookUp_L"),
              face::shape("eyeLookDown_L")},
    EyeShapes{face::shape("eyeLookIn_R"), face::shape("eyeLookOut_R"), face::shape("eyeLookUp_R"),
              face::shape("eyeLookDown_R")}};

/// Confidence factor: skin sensors hardly observe gaze.
inline constexpr float kGazeConfidence = 0.2f;

/// Whether a tracker gave the frame's eye directions, measured now or held: provenance not neutral, or
/// confidence left.
[[nodiscard]] inline bool has_eyes(const face::OutputFrame& frame) {
  return frame.eyes_provenance != face::Provenance::neutral || frame.eyes_confidence > 0;
}

/// Derives eye directions from the eyeLook weights where no tracker gave them (not has_eyes()): yaw and
/// pitch, kEyeTurnRad per unit weight. Confidence: kGazeConfidence times those shapes' mean. Provenance:
/// predicted, or the shapes' own where that is held, audio or neutral. No allocation. Thread-safe.
void eyes_from_weights(face::OutputFrame& frame);

}  // namespace mien::shaping
