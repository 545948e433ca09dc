#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/bytes.h"

namespace mien {

inline std::string hex(std::span<const std::byte> bytes) {
  static const char* const digits = "0123456789abcdef";
  std::string text;
  for (const std::byte b : bytes) {
    text += digits[std::to_integer<unsigned>(b) >> 4U];
    text += digits[std::to_integer<unsigned>(b) & 15U];
  }
  return text;
}

/// The bytes that lower-case hex digits stand for; blanks between them do not count.
inline std::vector<std::byte> bytes_of(std::string_view text) {
  std::vector<std::byte> bytes;
  unsigned high = 16;
  for (const char c : text) {
    if (c == ' ' || c == '\n') continue;
    const auto digit = static_cast<unsigned>(c <= '9' ? c - '0' : c - 'a' + 10);
    if (high == 16) {
      high = digit;
    } else {
      bytes.push_back(static_cast<std::byte>(high << 4U | digit));
      high = 16;
    }
  }
  return bytes;
}

/// Puts the checksum at a packet's end right again after a change, so that the change itself is judged.
inline void renew_checksum(std::vector<std::byte>& bytes) {
  ByteWriter writer;
  writer.append(std::span(bytes).first(bytes.size() - 4));
  writer.little(crc32(std::span<const std::byte>(bytes).first(bytes.size() - 4)));
  bytes = writer.release();
}

}  // namespace mien
