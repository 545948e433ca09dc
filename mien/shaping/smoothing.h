#pragma once

#include <array>
#include <optional>

#include "mien/core/one_euro.h"
#include "mien/face/output_frame.h"

namespace mien::shaping {

/// One Euro settings of weights, head and its position; none: not smoothed. core/one_euro.h explains the
/// fields.
struct SmoothingSettings {
  std::optional<OneEuroSettings> weights;
  std::optional<OneEuroSettings> head;
  std::optional<OneEuroSettings> position;
  bool operator==(const SmoothingSettings&) const = default;
};

/// The settings of the smoothing slider. `amount`: 0 to 1; 0: none. The cutoff at rest falls exponentially
/// from 15 Hz just above 0 to 1 Hz at 1: a delay at rest of 11 ms to 159 ms, 41 ms at 0.5. Beta reduces the
/// delay of fast movement: at a sustained 2 weights a second the cutoff is 6 Hz higher.
[[nodiscard]] SmoothingSettings smoothing_for(double amount, bool head);

/// One Euro filter (Casiez et al. 2012) on each weight and the tongue, and on the head's rotation and, while
/// it is known, its position. Off by default. On frame time; no allocation. Leaves confidence and provenance.
class Smoothing {
 public:
  void apply(face::OutputFrame& frame);
  /// Filters switched on start with the next frame's values; those already on keep their state.
  void set(const SmoothingSettings& settings);
  /// Resets the filters: the next frame passes unchanged.
  void reset();

 private:
  void smooth_position(face::OutputFrame& frame);

  SmoothingSettings settings_;
  std::array<OneEuro, face::kShapeCount + 1> weights_;  // The tongue's is the last.
  OneEuroRotation head_;
  std::array<OneEuro, 3> position_;
};

}  // namespace mien::shaping
