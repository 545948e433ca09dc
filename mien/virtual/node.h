#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/time.h"

namespace mien::virt {

/// One board of a virtual performer, as the network sees it: when it says what, and what it makes of answers.
/// A state machine without sockets and clocks: times are the sending machine's, passed in, and never run
/// back. It speaks from its first next_datagram() on, so that a receiver finds it before the performance
/// begins.
class Node {
 public:
  virtual ~Node() = default;

  /// The performance begins: its time 0 is `start`. Once, before what is due from then on is asked for.
  virtual void begin(HostTime start) = 0;
  /// When it next has something to say; what has yet to be played is not known of.
  [[nodiscard]] virtual HostTime due() const = 0;
  /// The next datagram that is due at `now`; ask until there is none.
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> next_datagram(HostTime now) = 0;
  /// A datagram from the receiver. What breaks its protocol's rules is ignored.
  virtual void receive(HostTime now, std::span<const std::byte> datagram) = 0;

  /// Its id, as its packets and rigs have it.
  [[nodiscard]] virtual std::uint64_t device() const = 0;
  /// It waits for a receiver's answers; one that only speaks does not.
  [[nodiscard]] virtual bool listens() const { return true; }
  /// The receiver knows of it, as far as it knows.
  [[nodiscard]] virtual bool answered() const = 0;
  /// All that was played has been said.
  [[nodiscard]] virtual bool idle() const = 0;
};

/// Devices are on this long before a performance begins and after it ends, s.
inline constexpr double kDeviceMarginS = 0.25;

/// A receiver that has not been heard for this long is gone; the node looks for it again.
inline constexpr Duration kReceiverGone = std::chrono::seconds(3);

/// The charge of a virtual board's battery after so long, 0 to 1: full at first, empty after eight hours.
[[nodiscard]] constexpr double battery_level(Duration on) {
  const double level = 1 - to_seconds(on) / (8 * 3600.0);
  return level < 0 ? 0 : level;
}

}  // namespace mien::virt
