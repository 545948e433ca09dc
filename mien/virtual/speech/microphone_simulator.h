#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/virtual/network.h"
#include "mien/virtual/speech/microphone_faults.h"
#include "mien/virtual/speech/sound_in_air.h"
#include "mien/virtual/virtual_clock.h"

namespace mien::virt {

/// One microphone that hears a performance, block after block of its own clock, in the packets of
/// docs/reference/protocol.md (type 14). The same stream gives the same packets. Not thread-safe.
class MicrophoneSimulator {
 public:
  /// A microphone whose clock is drawn. `sound` outlives this. `device`: its id, which is not this machine's.
  MicrophoneSimulator(const SoundInAir& sound, const MicrophoneFaults& faults, std::uint64_t device,
                      const Random& random);
  /// One with this clock.
  MicrophoneSimulator(const SoundInAir& sound, const MicrophoneFaults& faults, std::uint64_t device,
                      const Random& random, const VirtualClock& clock);

  [[nodiscard]] const VirtualClock& clock() const { return clock_; }
  /// True time up to which everything has been heard, s from the performance's time 0: the end of the last
  /// block, or when the microphone was switched on.
  [[nodiscard]] double heard_s() const;

  /// The next block: appends its packet, at its arrival, unless it is lost. No packet arrives before one that
  /// was sent earlier. `motion_s` gives the moment of the motion at a true time (both s). Errors: the
  /// packet's encoder's.
  Result<void> hear(const std::function<double(double)>& motion_s, std::vector<Datagram>& sent);

 private:
  const SoundInAir& sound_;
  MicrophoneFaults faults_;
  std::uint64_t device_;
  VirtualClock clock_;
  std::uint64_t next_;  // Block.
  Random noise_, delay_, loss_;
  double silent_until_s_;
  HostTime newest_ = HostTime::min();
};

}  // namespace mien::virt
