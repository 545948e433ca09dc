#pragma once

#include <optional>

#include "mien/core/newest.h"
#include "mien/speech/listener.h"

namespace mien::speech {

/// What a listener told lately, to be asked for any moment. No allocation.
class HeardTrack {
 public:
  /// Times rise from call to call.
  void push(const Heard& heard) { heard_.push(heard); }
  void clear() { heard_.clear(); }
  /// What was heard of the mouth at that time of the sound's clock: between two answers their mean by time,
  /// after the newest that one. None: nothing, or nothing so old.
  [[nodiscard]] std::optional<Heard> at(DeviceTime time) const;

 private:
  Newest<Heard, 32> heard_;  // A frame may be older than the newest.
};

/// Whether somebody speaks, with hysteresis.
class VoiceGate {
 public:
  /// From the first on somebody speaks, until it was below the second for kPause.
  static constexpr float kSpeaks = 0.6F, kSilent = 0.4F;
  static constexpr Duration kPause = std::chrono::milliseconds(300);

  /// `voice`: Heard's, at a time not before the last one's. True while somebody speaks.
  bool step(DeviceTime time, float voice);
  void reset();

 private:
  bool speaks_ = false;
  std::optional<DeviceTime> quiet_since_;
};

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
