#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/ease_out.h"
#include "mien/shaping/fallback_settings.h"

namespace mien::shaping {

/// Output while sensors are lost, and the return to the tracker's face.
///
/// All lost: the last frame is held, then eased to neutral (Fading). Sensors back, or another number of them
/// present: the offset from what is shown to the tracker's face decays (EaseOut), so the tracker's own
/// movement shows at once. The largest step per 60 Hz frame, besides the face's own, is by default 0.1 of the
/// offset on the way back and 0.05 of the weight on the way to neutral. On frame time; no allocation; frames
/// without a change in between keep their bits.
class Fallback {
 public:
  explicit Fallback(const FallbackSettings& settings);
  Fallback() : Fallback(FallbackSettings{}) {}

  /// `frame`: finite, changed in place. `sensors_present`: their number; 1 where only "any" is known.
  void apply(face::OutputFrame& frame, std::size_t sensors_present);
  /// New settings from the next frame on; times are clamped to their ranges.
  void set(const FallbackSettings& settings);
  /// Resets the state: the next frame passes unchanged.
  void reset() { *this = Fallback(settings_); }

 private:
  enum class Phase : std::uint8_t { waiting, following, lost };

  void lose(face::OutputFrame& frame);
  void follow(face::OutputFrame& frame, std::size_t sensors_present);
  /// Confidence and provenance during the return from a loss of all.
  void fade_in(face::OutputFrame& frame) const;

  FallbackSettings settings_;
  Phase phase_ = Phase::waiting;
  std::size_t sensors_present_ = 0;
  face::OutputFrame before_;  // The output frame before the last, ...
  face::OutputFrame shown_;   // ... and the last.
  face::OutputFrame from_;    // What was shown when all were lost, or came back.
  DeviceTime since_;          // Time of the loss, or of the newest offset.
  bool begun_ = false;        // shown_ was.
  bool returning_ = false;    // From a loss of all, not from a change of their number.
  EaseOut ease_out_;
};

}  // namespace mien::shaping
