#include "mien/render/image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace mien::render::jpeg_test {
namespace {

std::vector<std::uint8_t> waves(int width, int height) {
  std::vector<std::uint8_t> rgb;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (const double turn : {0.7, 0.4, 0.2})
        rgb.push_back(static_cast<std::uint8_t>(128 + 90 * std::sin(turn * x) * std::cos(turn * y)));
  return rgb;
}

struct Header {
  int width = 0, height = 0, channels = 0;
  int sampling = 0;  ///< Of the first channel, against the others'.
};

/// Of the baseline frame (marker SOF0, ITU-T T.81 B.2.2).
Header header(const std::vector<std::byte>& file) {
  const auto at = [&](std::size_t i) { return std::to_integer<int>(file.at(i)); };
  std::size_t i = 2;
  while (i + 4 < file.size() && at(i + 1) != 0xC0)
    i += 2 + 256U * static_cast<unsigned>(at(i + 2)) + static_cast<unsigned>(at(i + 3));
  return {.width = 256 * at(i + 7) + at(i + 8),
          .height = 256 * at(i + 5) + at(i + 6),
          .channels = at(i + 9),
          .sampling = at(i + 11)};
}

TEST(Jpeg, HasThePicturesSizeAndItsEnds) {
  const auto file = encode_jpeg(50, 30, JpegPixels::colour, 80, waves(50, 30)).value();
  EXPECT_EQ(std::to_integer<int>(file[0]), 0xFF);
  EXPECT_EQ(std::to_integer<int>(file[1]), 0xD8);
  EXPECT_EQ(std::to_integer<int>(file.back()), 0xD9);
  const Header h = header(file);
  EXPECT_EQ(h.width, 50);
  EXPECT_EQ(h.height, 30);
  EXPECT_EQ(h.channels, 3);
  EXPECT_EQ(h.sampling, 0x22) << "colours at half the size";
  EXPECT_EQ(header(encode_jpeg(50, 30, JpegPixels::data, 80, waves(50, 30)).value()).sampling, 0x11);
}

TEST(Jpeg, FinerIsLargerAndTheSamePixelsGiveTheSameBytes) {
  const auto rgb = waves(64, 64);
  const auto coarse = encode_jpeg(64, 64, JpegPixels::data, 20, rgb).value();
  EXPECT_GT(encode_jpeg(64, 64, JpegPixels::data, 95, rgb).value().size(), 2 * coarse.size());
  EXPECT_EQ(encode_jpeg(64, 64, JpegPixels::data, 20, rgb).value(), coarse);
}

TEST(Jpeg, RefusesWhatIsNoPicture) {
  const auto code = [](int width, int height, int quality, std::size_t bytes) {
    return encode_jpeg(width, height, JpegPixels::colour, quality, std::vector<std::uint8_t>(bytes))
        .error()
        .code;
  };
  EXPECT_EQ(code(0, 4, 80, 0), ErrorCode::out_of_range);
  EXPECT_EQ(code(4, -1, 80, 0), ErrorCode::out_of_range);
  EXPECT_EQ(code(16385, 1, 80, 49155), ErrorCode::out_of_range);
  EXPECT_EQ(code(4, 4, 80, 47), ErrorCode::out_of_range) << "one byte is missing";
  EXPECT_EQ(code(4, 4, 0, 48), ErrorCode::out_of_range);
  EXPECT_EQ(code(4, 4, 101, 48), ErrorCode::out_of_range);
}

TEST(Jpeg, OfGreyHasOneChannel) {
  std::vector<std::uint8_t> grey = waves(50, 30);
  grey.resize(50 * 30);
  const auto fine = encode_jpeg(50, 30, JpegPixels::grey, 95, grey).value();
  EXPECT_EQ(header(fine).channels, 1);
  EXPECT_EQ(header(fine).width, 50);
  EXPECT_GT(fine.size(), encode_jpeg(50, 30, JpegPixels::grey, 20, grey).value().size());
  EXPECT_FALSE(encode_jpeg(50, 30, JpegPixels::grey, 95, waves(50, 30))) << "three numbers a pixel";
}

}  // namespace
}  // namespace mien::render::jpeg_test
