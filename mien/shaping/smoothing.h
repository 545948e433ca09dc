#pragma once

#include <array>
#include <optional>

#include "mien/core/one_euro.h"
#include "mien/face/output_frame.h"

namespace mien::shaping {

/// What is smoothed, and how; none: not at all.
struct SmoothingSettings {
  std::optional<OneEuroSettings> weights;
  std::optional<OneEuroSettings> head;
  bool operator==(const SmoothingSettings&) const = default;
};

/// The settings behind a person's one slider. `amount`: 0 to 1; 0 is none. The cutoff at rest falls evenly in
/// octaves from 15 Hz just above 0 to 1 Hz at 1: a delay at rest of 11 ms to 159 ms, 41 ms in the middle.
/// Beta takes the delay out of quick movement: at 2 weights a second, sustained, the cutoff is 6 Hz higher.
[[nodiscard]] SmoothingSettings smoothing_for(double amount, bool head);

/// One Euro on each weight and the tongue, and on the head's rotation. Off, the default, costs nothing and
/// delays nothing. On frame time; no allocation. Confidence and provenance stay.
class Smoothing {
 public:
  void apply(face::OutputFrame& frame);
  /// What is switched on begins at the next frame as it is; what was on goes on from where it stands.
  void set(const SmoothingSettings& settings);
  /// The next frame goes through as it is.
  void reset();

 private:
  SmoothingSettings settings_;
  std::array<OneEuro, face::kShapeCount + 1> weights_;  // The tongue's is the last.
  OneEuroRotation head_;
};

}  // namespace mien::shaping
