#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "mien/core/error.h"

namespace mien {

/// Consistent overhead byte stuffing: bytes without any 0x00, so that 0x00 can end a frame on a serial line.
/// Each code byte is the distance to the next zero; 0xFF stands for 254 bytes with no zero after them.
/// Source: Cheshire and Baker 1999, doi:10.1109/90.769765.

/// The longest that `size` bytes become; without the 0x00 that ends the frame.
[[nodiscard]] constexpr std::size_t cobs_max_size(std::size_t size) {
  return size + size / 254 + 1;
}

/// Appends the frame to `out`, without the 0x00 that ends it.
void cobs_encode(std::span<const std::byte> bytes, std::vector<std::byte>& out);

/// What a frame holds, as the front of `out`, which must not overlap it; frame.size() bytes are always room
/// enough. The last code byte 0x01 that some encoders add after a full run is accepted. Errors: truncated
/// (empty, a code that points past the end), malformed (a zero inside), out_of_range (`out` is too small).
/// No allocation but in errors. Thread-safe.
[[nodiscard]] Result<std::span<const std::byte>> cobs_decode(std::span<const std::byte> frame,
                                                             std::span<std::byte> out);

}  // namespace mien
