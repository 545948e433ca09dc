#pragma once

#include <cstddef>
#include <string_view>

namespace mien {

/// How many bytes the first letter of a text has, 1 to 4; 0 where the text is empty or does not begin with
/// well-formed UTF-8: no overlong forms, no surrogates, nothing beyond U+10FFFF. Source: The Unicode Standard
/// 15.0, table 3-7.
[[nodiscard]] constexpr std::size_t utf8_letter(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  std::size_t length = 0;
  unsigned char low = 0x80;  // Range of the second byte.
  unsigned char high = 0xBF;
  if (first >= 0xC2 && first <= 0xDF) {
    length = 2;
  } else if (first >= 0xE0 && first <= 0xEF) {
    length = 3;
    if (first == 0xE0) low = 0xA0;
    if (first == 0xED) high = 0x9F;
  } else if (first >= 0xF0 && first <= 0xF4) {
    length = 4;
    if (first == 0xF0) low = 0x90;
    if (first == 0xF4) high = 0x8F;
  } else {
    return 0;
  }
  if (text.size() < length || byte(1) < low || byte(1) > high) return 0;
  for (std::size_t k = 2; k < length; ++k)
    if (byte(k) < 0x80 || byte(k) > 0xBF) return 0;
  return length;
}

/// The code point of a letter: of all bytes that utf8_letter() counts.
[[nodiscard]] constexpr char32_t code_point(std::string_view letter) {
  const auto byte = [&](std::size_t at) {
    return static_cast<char32_t>(static_cast<unsigned char>(letter[at]));
  };
  if (letter.size() == 1) return byte(0);
  // The first byte's own bits are those below its ones and a zero.
  char32_t point = byte(0) & (0x7FU >> letter.size());
  for (std::size_t i = 1; i < letter.size(); ++i) point = point << 6U | (byte(i) & 0x3FU);
  return point;
}

/// Whether text is well-formed UTF-8. Texts of a take are, so that whatever prints them as JSON need not
/// wonder.
[[nodiscard]] constexpr bool is_utf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = utf8_letter(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

}  // namespace mien
