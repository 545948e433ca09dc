#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"

namespace mien::speech {

/// A piece of sound as the page sends it from a browser's microphone: one channel, 16 bits, at the browser's
/// own rate. Layout, byte by byte: docs/reference/page_protocol.md.
struct SoundMessage {
  int rate_hz = 0;  ///< kLowestRateHz to kHighestRateHz.
  std::uint64_t count =
      0;  ///< Samples before these since the sound began, lost ones too; below kMostSamples.
  std::vector<std::int16_t> samples;  ///< 1 to rate_hz / kMessagesPerSecond.
  bool operator==(const SoundMessage&) const = default;
};

inline constexpr int kLowestRateHz = 8'000;
inline constexpr int kHighestRateHz = 192'000;
/// A message has a tenth of a second at most.
inline constexpr int kMessagesPerSecond = 10;
/// A browser's numbers count exactly so far.
inline constexpr std::uint64_t kMostSamples = std::uint64_t{1} << 53U;
inline constexpr std::size_t kMessageHeadBytes = 20;

/// Errors: truncated; malformed (magic, reserved bytes, half a sample, too many samples); unsupported
/// (version); out_of_range (rate, count). Thread-safe.
[[nodiscard]] Result<SoundMessage> parse_message(std::span<const std::byte> bytes);
/// Inverse of parse_message, to the byte.
[[nodiscard]] std::vector<std::byte> encode_message(const SoundMessage& message);

}  // namespace mien::speech
