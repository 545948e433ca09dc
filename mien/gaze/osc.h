#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>

#include "mien/core/error.h"

namespace mien::gaze {

/// Bundles inside bundles: more levels than this are refused. Senders use one.
inline constexpr int kMostBundles = 8;
/// Numbers of a message that are kept.
inline constexpr std::size_t kMostNumbers = 6;

/// One OSC message. Refers to the datagram.
struct OscMessage {
  std::string_view address;                    ///< Begins with '/'.
  std::array<double, kMostNumbers> numbers{};  ///< Its first arguments, where all are numbers.
  std::size_t count = 0;                       ///< How many arguments it has.
  bool numeric = false;                        ///< All arguments are numbers (i, f, h, d).
  std::string_view types;                      ///< Their type tags, without the comma.
};

/// What is told of all that a datagram holds, message after message, in order.
class OscListener {
 public:
  virtual ~OscListener() = default;
  /// Errors: the listener's own; they end the reading.
  virtual Result<void> hear(const OscMessage& message) = 0;
};

/// Whether the bytes begin like OSC: an address that ends, or a bundle. Checks no more.
[[nodiscard]] bool is_osc(std::span<const std::byte> datagram);

/// Reads a datagram of OSC 1.0: a message or a bundle of bundles and messages. Time tags are passed over. No
/// allocation but in errors. Errors: truncated (a string, blob or element longer than what is left),
/// malformed (no address, unknown type tags, a size that is no multiple of four, more than kMostBundles
/// levels), the listener's. Source: opensoundcontrol.org, "The Open Sound Control 1.0 Specification".
[[nodiscard]] Result<void> read_osc(std::span<const std::byte> datagram, OscListener& listener);

}  // namespace mien::gaze
