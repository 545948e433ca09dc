#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace mien::headset {

/// Finds where a JPEG in a stream of bytes ends: it follows the lengths of its segments, so that an FF D9 in
/// a thumbnail, or text that looks like a boundary, ends nothing. Judges no more than that (jpeg_gate.h
/// does). No allocation.
class JpegWalker {
 public:
  enum class State : std::uint8_t {
    inside,
    whole,   ///< The byte was the picture's last, and there was a scan before it.
    broken,  ///< The byte cannot stand there: it, or one before it, is no part of the picture.
  };

  /// A picture begins: the first byte to be added is its first, FF.
  void begin() { *this = {}; }
  /// Takes the next byte. After `whole` and `broken` nothing may be added before begin().
  State add(std::byte byte);
  /// How many of the next bytes are coded data, which add() would take as State::inside and nothing else:
  /// they need not be added. 0 in a picture's header.
  [[nodiscard]] std::size_t coded_run(std::span<const std::byte> next) const;

 private:
  enum class At : std::uint8_t {
    first,
    second,
    mark,
    code,
    length_high,
    length_low,
    segment,
    coded,
    coded_mark
  };
  State end_of_segment();

  At at_ = At::first;
  bool scan_ = false;       // The segment is a scan's header: coded data follow.
  bool scanned_ = false;    // There was one.
  std::uint32_t left_ = 0;  // Bytes of the segment.
};

}  // namespace mien::headset
