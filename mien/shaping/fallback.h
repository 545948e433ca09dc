#pragma once

#include <cstddef>

#include "mien/face/output_frame.h"
#include "mien/shaping/letting_go.h"

namespace mien::shaping {

struct FallbackSettings {
  /// s, 0 to 10: how long the last frame is held when all sensors are lost. Raising bridges longer gaps and
  /// leaves the avatar staring longer.
  double hold_s = 0.3;
  /// s, 0.05 to 10: how long it then takes to neutral.
  double neutral_s = 0.5;
  /// s, 0.05 to 10: in which 95 % of the way from what is shown to the tracker's face is gone when sensors
  /// come back or change. Raising is smoother and truer later.
  double return_s = 0.3;
  static constexpr double kShortest_s = 0.05;
  static constexpr double kLongest_s = 10;
  bool operator==(const FallbackSettings&) const = default;
};

/// What is shown when sensors are lost, and how the tracker's face is taken up again.
///
/// All lost: the last frame is held, then eased to neutral: weights to 0, eyes straight ahead, the head
/// upright at the yaw where it was (a face that turned away by itself would be worse than one that keeps
/// looking there). Provenance held while holding, then neutral; confidence falls evenly to 0 over both.
/// Back, or another number of sensors there: what is shown goes on from where it was. The difference to the
/// tracker's face is let go (LettingGo), so the tracker's own movement shows at once. The largest step a
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
  LettingGo letting_go_;
};

}  // namespace mien::shaping
