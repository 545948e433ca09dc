#pragma once

#include "mien/face/output_frame.h"
#include "mien/shaping/ease_out.h"

namespace mien::shaping {

/// The head's position where it begins or ends to be known: only some trackers tell it, and who does not know
/// it shows it at 0. The offset from what was shown decays (EaseOut), and while it does the position counts
/// as known. Behind re-centring, which has put 0 where the performer is. Frames without a change keep their
/// bits. On frame time; no allocation.
class HeadPosition {
 public:
  /// `return_s`: as FallbackSettings has it, > 0.
  void apply(face::OutputFrame& frame, double return_s);
  /// Resets the state: the next frame is not eased.
  void reset() { *this = HeadPosition(); }

 private:
  bool begun_ = false;
  bool known_ = false;  // Told with the last frame.
  face::OutputFrame shown_;
  EaseOut ease_out_;
};

}  // namespace mien::shaping
