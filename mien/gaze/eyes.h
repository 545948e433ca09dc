#pragma once

#include <array>
#include <optional>

#include "mien/core/time.h"
#include "mien/sensor/sample.h"

namespace mien::gaze {

/// Largest yaw and pitch of an eye, each way: a quarter turn, rad.
inline constexpr float kMostRad = 1.5707964F;
/// Largest diameter of a pupil, mm; human pupils have 2 to 8.
inline constexpr float kMostPupilMm = 20;

/// What is known of one eye.
struct Eye {
  /// Direction in the head frame, rad, within kMostRad: yaw to the performer's left, then pitch upwards, as
  /// face::OutputFrame::eyes_rad. Means nothing where confidence is 0.
  float yaw_rad = 0;
  float pitch_rad = 0;
  /// How sure the sender is of the direction, 0 to 1; 0: this eye is not seen.
  float confidence = 0;
  std::optional<float> openness;  ///< Of the lids: 0 closed, 1 open as at rest.
  std::optional<float> pupil_mm;  ///< Diameter, 0 to kMostPupilMm.
  bool operator==(const Eye&) const = default;
};

/// Left eye, right eye.
using Eyes = std::array<Eye, 2>;

/// Whether every number is finite and in its range.
[[nodiscard]] bool is_sound(const Eye& eye);

/// A sample of SampleKind::gaze: of the left eye yaw and pitch (rad), confidence, openness and pupil (mm),
/// then of the right; -1 for an openness or pupil that is not known. Sensor, sequence and time are the
/// caller's.
[[nodiscard]] sensor::Sample sample_of(const Eyes& eyes);
/// The eyes of such a sample; none of another kind or with a number out of its range.
[[nodiscard]] std::optional<Eyes> eyes_of(const sensor::Sample& sample);

}  // namespace mien::gaze
