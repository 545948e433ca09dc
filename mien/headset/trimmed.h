#pragma once

#include <string_view>

namespace mien::headset {

/// Without blanks and tabs before it, and without any of `behind` behind it.
[[nodiscard]] inline std::string_view trimmed(std::string_view text, std::string_view behind = " \t") {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  text.remove_prefix(first);
  return text.substr(0, text.find_last_not_of(behind) + 1);
}

}  // namespace mien::headset
