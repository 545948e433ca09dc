#pragma once

#include <array>

#include "mien/face/output_frame.h"
#include "mien/shaping/ease_out.h"

namespace mien::shaping {

/// Lids that follow the eyes: where a tracker gave eye directions (has_eyes) the eight eyeLook shapes are
/// theirs, weight = angle / kEyeTurnRad, at most 1, with the directions' confidence and provenance. Each eye
/// by itself, and only one of whose four shapes none is measured or interpolated: what a tracker saw of the
/// lids stays. While shapes and directions are both held nothing changes hands.
///
/// Where an eye's shapes change hands, either way, the offset from what was shown decays (EaseOut). Frames
/// without directions of a tracker keep their bits. On frame time; no allocation.
class Lids {
 public:
  /// `follow`: false leaves the shapes to their tracker. `return_s`: as FallbackSettings has it, > 0.
  void apply(face::OutputFrame& frame, bool follow, double return_s);
  /// Resets the state: the next frame is not eased.
  void reset() { *this = Lids(); }

 private:
  std::array<bool, 2> follow_{};  // The eye's shapes are the directions'.
  bool begun_ = false;
  face::OutputFrame shown_;  // The last output.
  EaseOut ease_out_;
};

}  // namespace mien::shaping
