#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mien::sensor {

/// Cuts a stream of bytes, as a serial line gives it, into frames, without knowing what they mean. A frame
/// ends at 0x00, where binary frames end that are stuffed (core/cobs.h); or at a newline, when all its bytes
/// are printable text, or when the frame before it ended at one: then a damaged line costs itself alone. A
/// newline that is a frame's first byte may be a stuffed frame's first code, and is left out of lines. A
/// carriage return before the newline is left out too, and so are frames of no bytes. Longer ones than
/// kMaxFrame are dropped whole and counted; they end at either. No allocation. Thread: one at a time.
class StreamFramer {
 public:
  static constexpr std::size_t kMaxFrame = 512;

  /// Takes one byte. The frame that it ends, without its end; else nothing. Valid until the next call.
  [[nodiscard]] std::span<const std::byte> add(std::byte byte);
  /// The line was opened anew: what it had begun never comes to its end.
  void restart();

  /// Frames that were too long.
  [[nodiscard]] std::uint64_t overlong() const { return overlong_; }

 private:
  std::span<const std::byte> end(bool newline);

  std::array<std::byte, kMaxFrame> frame_{};
  std::size_t size_ = 0;
  bool too_long_ = false;
  bool printable_ = true;    // All bytes since the last end.
  bool after_line_ = false;  // The last end was a newline.
  std::uint64_t overlong_ = 0;
};

}  // namespace mien::sensor
