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

}  // namespace mien::speech
