#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/bytes.h"

// OSC as senders write it: an emulated sender's half.
namespace mien::gaze::test {

inline void write_text(std::string_view text, ByteWriter& out) {
  out.append(text);
  for (std::size_t i = text.size() % 4; i < 4; ++i) out.little(std::uint8_t{0});
}

/// A message of floats.
inline std::vector<std::byte> message(std::string_view address, const std::vector<float>& numbers) {
  ByteWriter out;
  write_text(address, out);
  write_text("," + std::string(numbers.size(), 'f'), out);
  for (const float number : numbers) out.big(number);
  return out.release();
}

/// A bundle, to be sent at once.
inline std::vector<std::byte> bundle(const std::vector<std::vector<std::byte>>& elements) {
  ByteWriter out;
  write_text("#bundle", out);
  out.big(std::uint64_t{1});
  for (const auto& element : elements) {
    out.big(static_cast<std::uint32_t>(element.size()));
    out.append(element);
  }
  return out.release();
}

}  // namespace mien::gaze::test
