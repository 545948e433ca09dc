#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/ease_out.h"
#include "mien/shaping/fallback_settings.h"

namespace mien::shaping {

/// What is shown when sensors are lost, and how the tracker's face is taken up again.
///
/// All lost: the last frame is held, then eased to neutral (Fading).
/// Back, or another number of sensors there: what is shown goes on from where it was. The difference to the
/// tracker's face is let go (EaseOut), so the tracker's own movement shows at once. The largest step a
/// 60 Hz frame besides the face's own is 0.1 of the difference on the way back and 0.05 of the weight on the
/// way to neutral.
/// On frame time; no allocation; a frame that follows without a change keeps its bits.
class Fallback {
 public:
  explicit Fallback(const FallbackSettings& settings);
  Fallback() : Fallback(FallbackSettings{}) {}

  /// `frame` is finite. `sensors_there`: how many sensors were heard lately; where only "any" is known, 1.
  void apply(face::OutputFrame& frame, std::size_t sensors_there);
  /// Keeps what is shown. Times out of range are brought into it.
  void set(const FallbackSettings& settings);
  /// Forgets what was shown: the next frame goes through as it is.
  void reset() { *this = Fallback(settings_); }

 private:
  enum class Phase : std::uint8_t { waiting, following, lost };

  void lose(face::OutputFrame& frame);
  void follow(face::OutputFrame& frame, std::size_t sensors_there);
  /// Confidence and provenance while the tracker's face is taken up again.
  void tell_of_return(face::OutputFrame& frame) const;

  FallbackSettings settings_;
  Phase phase_ = Phase::waiting;
  std::size_t sensors_there_ = 0;
  face::OutputFrame shown_;  // The last frame as it left.
  face::OutputFrame from_;   // What was shown when sensors were lost, or when they came back.
  DeviceTime since_;         // Of the loss, or of the newest difference.
  bool returning_ = false;   // From a loss of all, not from a change.
  EaseOut ease_out_;
};

}  // namespace mien::shaping
