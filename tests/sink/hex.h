#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace mien::sink::test {

/// "2f00", two small digits a byte.
inline std::string hex(std::span<const std::byte> bytes) {
  static const char* const digits = "0123456789abcdef";
  std::string text;
  for (const std::byte b : bytes) {
    text += digits[std::to_integer<unsigned>(b) >> 4U];
    text += digits[std::to_integer<unsigned>(b) & 15U];
  }
  return text;
}

}  // namespace mien::sink::test
