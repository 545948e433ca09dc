#pragma once

#include <optional>

#include "mien/speech/heard_track.h"

namespace mien::speech {

/// The mouth of whoever speaks, frame by frame: what a listener told, while VoiceGate says that somebody
/// speaks, as smooth as a mouth. No allocation. A pure function of the calls.
class SpokenMouth {
 public:
  /// `rate`: 1/s, of a critically damped follower of second order, which is 2 / rate late; 0: none. Raising:
  /// quicker, and rougher (Listener::smoothing()).
  explicit SpokenMouth(double rate = 0) : rate_(rate) {}

  void push(const Heard& heard) { track_.push(heard); }
  /// At a frame's time of the sound's clock, which rises from call to call; none while nobody speaks.
  [[nodiscard]] std::optional<Heard> tick(DeviceTime time);
  void reset();

 private:
  /// A value that follows another.
  struct Follower {
    float value = 0, speed = 0;  // Speed: 1/s.
    void step(float target, double rate, double seconds);
  };

  double rate_;
  HeardTrack track_;
  VoiceGate gate_;
  std::array<Follower, face::kShapeCount> weights_;
  Follower tongue_, closure_;
  std::optional<DeviceTime> last_;
};

}  // namespace mien::speech
