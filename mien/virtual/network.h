#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/take/take.h"

namespace mien::virt {

/// What a network does to datagrams on their way. The defaults are a perfect one.
struct NetworkSettings {
  /// Share of datagrams lost, each by itself; 0 to 1.
  double loss = 0;
  /// Bursts (Gilbert and Elliott's two states, one pair a source): the share of datagrams that are sent while
  /// the way is shut, all of which are lost, and how many in a row on average. 0 to below 1; 1 or more.
  double burst_share = 0;
  double burst_length = 10;
  /// Every datagram takes this long, and a random time more: of this mean, or evenly up to twice it. 0 to 10
  /// s. One may overtake those that its source sent before.
  double lag_ms = 0;
  double jitter_ms = 0;
  enum class Jitter : std::uint8_t { exponential, uniform };
  Jitter jitter = Jitter::exponential;
  double duplicated = 0;  ///< Share that arrives twice, each on a way of its own; 0 to 1.
  double corrupted = 0;   ///< Share with one to four bytes changed; 0 to 1.
  double truncated = 0;   ///< Share of which only a beginning arrives, maybe none of it; 0 to 1.
};

/// One datagram on a network.
struct Datagram {
  HostTime time;             ///< When it is sent; of what deliver() gives, when it arrives.
  std::uint16_t source = 0;  ///< Which node sends it.
  std::vector<std::byte> bytes;
  std::vector<std::byte> payload = {};  ///< Beside it, as a session's log has one; no network carries it.
};

/// Those of one moment keep their order.
void sort_by_time(std::vector<Datagram>& datagrams);

/// What arrives, by arrival. Each kind of fault and each source has a random stream of its own: changing one
/// leaves the others as they were. Shape: `sent` in each source's order of sending. Errors: out_of_range (a
/// setting).
[[nodiscard]] Result<std::vector<Datagram>> deliver(std::span<const Datagram> sent,
                                                    const NetworkSettings& settings, const Random& random);

}  // namespace mien::virt
