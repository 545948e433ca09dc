#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/fallback_settings.h"

namespace mien::shaping {

/// What becomes of a part of a frame that no sensor stands behind any more: held, then eased to neutral:
/// weights to 0, eyes straight ahead, the head upright at the yaw where it was (a face that turned away by
/// itself would be worse than one that keeps looking there). Provenance held while holding, then neutral;
/// confidence falls evenly to 0 over both. The largest step a 60 Hz frame is 0.05 of the weight. No
/// allocation. Thread-safe.
class Fading {
 public:
  /// `age_s`: since the part was known.
  Fading(double age_s, const FallbackSettings& settings);
  /// Fills the part (frame_parts.h) of `frame`. `from`: as it was shown last while it was known.
  void apply(std::size_t part, const face::OutputFrame& from, face::OutputFrame& frame) const;

 private:
  [[nodiscard]] face::Provenance told(face::Provenance was) const;

  double gone_;  // Share of the way to neutral.
  float left_;   // 1 - gone_.
  float sure_;   // Share of the confidence.
  bool held_;
};

}  // namespace mien::shaping
