#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mien/live/byte_ring.h"
#include "mien/live/signal.h"

namespace mien::live {

/// Binary messages of one of the page's clients on their way to a feed: whose, says the network's thread, and
/// only these wait, up to a fixed number of bytes. No lock.
class PageInlet {
 public:
  using Clock = std::chrono::steady_clock;
  /// What may wait, bytes: two seconds of the highest rate.
  static constexpr std::size_t kQueueBytes = std::size_t{1} << 20U;

  PageInlet() : ring_(kQueueBytes) {}

  // Network thread.
  /// From now on this client is listened to, and no other; 0: nobody.
  void admit(std::uint64_t client) { admitted_ = client; }
  /// False where it is refused, which is counted: the client is not the admitted one, or too much waits.
  bool offer(std::uint64_t client, std::span<const std::byte> bytes, Clock::time_point now);

  // Feed's thread.
  struct Message {
    std::uint64_t client;
    Clock::time_point arrival;
    std::span<const std::byte> bytes;
  };
  /// The oldest, valid until release(); none: nothing waits.
  [[nodiscard]] std::optional<Message> front();
  void release() { ring_.release(); }
  /// Returns when a message may be there, or after `at_most`.
  void wait(Duration at_most) { awake_.wait(at_most); }
  /// The feed could make nothing of one.
  void count_refused() { refused_.fetch_add(1, std::memory_order_relaxed); }

  // Any thread.
  [[nodiscard]] std::uint64_t admitted() const { return admitted_; }
  /// Messages that were not heard, for whatever reason.
  [[nodiscard]] std::uint64_t refused() const { return refused_.load(std::memory_order_relaxed); }

 private:
  ByteRing ring_;
  Signal awake_;
  std::atomic<std::uint64_t> admitted_ = 0;
  std::atomic<std::uint64_t> refused_ = 0;
};

}  // namespace mien::live
