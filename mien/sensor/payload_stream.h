#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien::sensor {

/// What became of the payloads of a stream.
struct StreamCounts {
  std::uint64_t whole = 0;
  std::uint64_t broken = 0;    ///< They ended too early, or are not what the stream carries.
  std::uint64_t overlong = 0;  ///< Longer than kMaxPayload.
  std::uint64_t refused = 0;   ///< Whole, but of a kind that is not taken; refusals() says which.
  /// Those that were begun and are over.
  [[nodiscard]] std::uint64_t all() const { return whole + broken + overlong + refused; }
  bool operator==(const StreamCounts&) const = default;
};

/// How many payloads of a stream were refused for one reason.
struct Refusal {
  std::string_view why;  ///< For people: "progressive". Lives as long as the program.
  std::uint64_t count = 0;
  bool operator==(const Refusal&) const = default;
};

/// What a device says that is connected as a stream of bytes (over TCP, a serial line) and sends payloads:
/// who has the connection gives the bytes as they come, and hands on the datagrams with their payloads
/// (payload.h) that come out. A pure function of the bytes and of where the stream began anew. No allocation
/// on the way. Thread: one at a time.
class PayloadStream {
 public:
  virtual ~PayloadStream() = default;

  /// Both are valid during the call.
  using OnPayload =
      std::function<void(std::span<const std::byte> datagram, std::span<const std::byte> payload)>;

  /// A connection begins. What the one before left open is broken.
  virtual void restart() = 0;
  /// The next bytes of the connection; `on_payload` is called for each payload that they complete. Errors,
  /// which say what to do: the other end is no such device, or has ended the stream. The connection is then
  /// to be closed, and nothing may be read before restart().
  [[nodiscard]] virtual Result<void> read(std::span<const std::byte> bytes, const OnPayload& on_payload) = 0;
  /// Since the beginning, over all connections.
  [[nodiscard]] virtual StreamCounts counts() const = 0;
  /// The reasons for which payloads were refused so far, the most frequent first.
  [[nodiscard]] virtual std::vector<Refusal> refusals() const = 0;
};

}  // namespace mien::sensor
