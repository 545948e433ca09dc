#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/fallback_settings.h"

namespace mien::shaping {

/// Loss of tracking of one part of a frame: held for hold_s, then eased (smoothstep, neutral_s) to neutral:
/// weights 0, eyes straight ahead, head upright at its last yaw and place (a head that turned or walked by
/// itself would look worse). Provenance: held, then neutral; confidence falls linearly to 0 over both. The
/// largest step per 60 Hz frame is 0.05 of the weight by default. No allocation. Thread-safe.
class Fading {
 public:
  /// `age_s`: since the last frame with the part observed.
  Fading(double age_s, const FallbackSettings& settings);
  /// Fills the part (frame_parts.h) of `frame`. `from`: the last frame shown with the part observed.
  void apply(std::size_t part, const face::OutputFrame& from, face::OutputFrame& frame) const;
  /// What is left of a confidence.
  [[nodiscard]] float fade(float confidence) const { return confidence_share_ * confidence; }

 private:
  [[nodiscard]] face::Provenance provenance_of(face::Provenance was) const;

  double gone_;             // Eased share of the way to neutral, 0 to 1.
  float left_;              // 1 - gone_.
  float confidence_share_;  // Remaining share of the confidence.
  bool held_;
};

}  // namespace mien::shaping
