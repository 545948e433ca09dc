#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "mien/core/time.h"
#include "mien/live/byte_ring.h"
#include "mien/live/signal.h"
#include "mien/sensor/payload.h"
#include "mien/sensor/protocol.h"

namespace mien::live {

/// A device inside this program, a camera's or a microphone's thread: what it hands over are datagrams with a
/// payload beside them, in a queue of their own, so that pictures take no room from the network's packets.
class PayloadSource {
 public:
  /// What may wait for the tracker's thread, bytes: 31 of the longest payloads, half a second of 60 pictures
  /// a second. The machine's memory is taken as they come.
  static constexpr std::size_t kQueueBytes = std::size_t{1} << 23U;
  /// Bytes: as a network's frame has them.
  static constexpr std::size_t kMaxDatagram = 1472;

  using Clock = std::function<HostTime()>;
  /// `awake` is given a signal at every hand-over, and outlives it. `clock` may be asked on any thread.
  PayloadSource(sensor::Peer peer, Clock clock, Signal& awake);

  /// Stamps a datagram with its arrival, and copies it and its payload, which may be empty. False where it is
  /// refused, which is counted: one of the two is too long, or the tracker is too far behind. Thread: the
  /// source's, one at a time. No allocation, no lock.
  bool hand_over(std::span<const std::byte> datagram, std::span<const std::byte> payload);

  // Tracker's thread.
  struct Waiting {
    HostTime arrival;
    std::span<const std::byte> datagram;
    std::span<const std::byte> payload;
  };
  /// The oldest, valid until release(); none when all is taken.
  [[nodiscard]] std::optional<Waiting> front();
  void release() { ring_.release(); }

  struct Counts {
    std::uint64_t received = 0;
    std::uint64_t too_long = 0;
    std::uint64_t overrun = 0;  ///< The tracker was too far behind.
  };
  /// Any thread.
  [[nodiscard]] Counts counts() const;
  [[nodiscard]] sensor::Peer peer() const { return peer_; }

 private:
  sensor::Peer peer_;
  Clock clock_;
  Signal& awake_;
  ByteRing ring_;
  std::atomic<std::uint64_t> received_ = 0;
  std::atomic<std::uint64_t> too_long_ = 0;
  std::atomic<std::uint64_t> overrun_ = 0;
};

}  // namespace mien::live
