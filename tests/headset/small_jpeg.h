#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "mien/render/image.h"

// Pictures for tests of what reads them.
namespace mien::headset::test {

using Bytes = std::vector<std::byte>;

/// Rings around a point that depends on the number: grey, row by row from the top.
inline std::vector<std::uint8_t> rings(int width, int height, int number) {
  std::vector<std::uint8_t> grey;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double distance = std::hypot(x - width * (0.3 + 0.01 * number), y - height * 0.6);
      grey.push_back(static_cast<std::uint8_t>(128 + 90 * std::cos(distance * 40 / width)));
    }
  return grey;
}

inline Bytes grey_jpeg(int width, int height, int number, int quality = 85) {
  auto made =
      render::encode_jpeg(width, height, render::JpegPixels::grey, quality, rings(width, height, number));
  EXPECT_TRUE(made) << made.error().message();
  return made ? *made : Bytes();
}

/// The same picture in colour, as most cameras send it.
inline Bytes colour_jpeg(int width, int height, int number) {
  std::vector<std::uint8_t> rgb;
  for (const std::uint8_t level : rings(width, height, number)) rgb.insert(rgb.end(), 3, level);
  return render::encode_jpeg(width, height, render::JpegPixels::colour, 85, rgb).value();
}

inline Bytes text_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline Bytes& operator+=(Bytes& to, std::span<const std::byte> more) {
  to.insert(to.end(), more.begin(), more.end());
  return to;
}
inline Bytes& operator+=(Bytes& to, std::string_view text) {
  return to += std::as_bytes(std::span(text));
}

/// Where a marker of this code stands first; the size where there is none.
inline std::size_t place_of(const Bytes& jpeg, unsigned code) {
  for (std::size_t i = 0; i + 1 < jpeg.size(); ++i)
    if (jpeg[i] == std::byte{0xFF} && jpeg[i + 1] == static_cast<std::byte>(code)) return i;
  return jpeg.size();
}

/// With a segment of this code and content before all others.
inline Bytes with_segment(const Bytes& jpeg, unsigned code, std::span<const std::byte> content) {
  const std::size_t length = content.size() + 2;
  Bytes out(jpeg.begin(), jpeg.begin() + 2);
  out += std::array{std::byte{0xFF}, static_cast<std::byte>(code), static_cast<std::byte>(length >> 8U),
                    static_cast<std::byte>(length)};
  out += content;
  out.insert(out.end(), jpeg.begin() + 2, jpeg.end());
  return out;
}

/// Longer than sensor::kMaxPayload, by comments.
inline Bytes overlong_jpeg(const Bytes& jpeg) {
  Bytes out = jpeg;
  for (int i = 0; i < 5; ++i) out = with_segment(out, 0xFE, Bytes(65000, std::byte{'c'}));
  return out;
}

}  // namespace mien::headset::test
