#pragma once

#include <algorithm>
#include <string_view>

namespace mien {

/// The small letter of A to Z; every other byte as it is.
[[nodiscard]] constexpr char ascii_lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

[[nodiscard]] constexpr bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return ascii_lower(x) == ascii_lower(y); });
}

/// Whether a text has control characters, which a terminal would obey.
[[nodiscard]] constexpr bool has_control(std::string_view text) {
  return std::ranges::any_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7F; });
}

/// Without blanks and tabs before it, and without any of `behind` behind it.
[[nodiscard]] inline std::string_view trimmed(std::string_view text, std::string_view behind = " \t") {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  text.remove_prefix(first);
  return text.substr(0, text.find_last_not_of(behind) + 1);
}

}  // namespace mien
