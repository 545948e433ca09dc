#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "mien/core/error.h"
#include "mien/eyewear/packet.h"

namespace mien::eyewear {

/// Most values of one line: a pair for each channel.
inline constexpr std::size_t kMaxTextValues = 2 * kMaxChannels;

/// "512,498,1003": one scan, as printed by a sketch.
struct TextValues {
  std::size_t count = 0;                              ///< 1 to kMaxTextValues.
  std::array<std::int32_t, kMaxTextValues> values{};  ///< Converter steps, magnitude up to 2^kMaxAdcBits.
};

/// "# mien on off bits 12": the meaning of the values in the following lines.
struct TextHeader {
  bool pairs = false;         ///< LED on and off of each sensor in turn; else their difference.
  std::uint8_t adc_bits = 0;  ///< kMinAdcBits to kMaxAdcBits; 0 where not given.
  bool operator==(const TextHeader&) const = default;
};

/// Any other line beginning with '#'; ignored.
struct TextComment {};

using TextLine = std::variant<TextValues, TextHeader, TextComment>;

/// Whether the bytes are non-empty and all printable ASCII, blanks or line ends.
[[nodiscard]] bool is_text_line(std::span<const std::byte> bytes);

/// Parses one line, with or without its end. Integers in decimal stand between commas, semicolons or blanks
/// (tabs, spaces); blanks beside a comma or semicolon do not count, and one separator may follow the last
/// value. Errors: malformed (a value missing or no integer, a header with a word that is unknown, no value at
/// all), out_of_range (too many values, one beyond 16 bits, bits). No allocation but in errors. Thread-safe.
/// Format: docs/reference/protocol.md.
[[nodiscard]] Result<TextLine> parse_text_line(std::span<const std::byte> line);

}  // namespace mien::eyewear
