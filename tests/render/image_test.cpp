#include "mien/render/image.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "mien/core/bytes.h"
#include "mien/core/files.h"
#include "tests/folder.h"

namespace mien::render::image_test {
namespace {

TEST(Image, FillsEveryPixel) {
  const Image picture(3, 2, {10, 20, 30});
  ASSERT_EQ(picture.rgb.size(), 18U);
  EXPECT_EQ(picture.pixel(2, 1)[0], 10);
  EXPECT_EQ(picture.pixel(2, 1)[2], 30);
}

TEST(Image, PastesInsideAndLeavesOutTheRest) {
  Image picture(4, 4, {0, 0, 0});
  paste(picture, Image(3, 3, {255, 0, 0}), 2, 2);
  paste(picture, Image(3, 3, {0, 255, 0}), -2, -2);
  paste(picture, Image(2, 2, {0, 0, 255}), 9, 9);
  EXPECT_EQ(picture.pixel(3, 3)[0], 255);
  EXPECT_EQ(picture.pixel(0, 0)[1], 255);
  EXPECT_EQ(picture.pixel(1, 1)[1], 0);
  for (std::size_t i = 2; i < picture.rgb.size(); i += 3) EXPECT_EQ(picture.rgb[i], 0);
}

TEST(Png, SaysItsSizeAndChecksItself) {
  const auto content = encode_png(Image(300, 7, {1, 2, 3}));
  ASSERT_TRUE(content.has_value());
  ByteReader reader(*content);
  constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  for (const std::uint8_t byte : kSignature) EXPECT_EQ(reader.big<std::uint8_t>(), byte);
  EXPECT_EQ(reader.big<std::uint32_t>(), 13U);
  const auto header = reader.take(17);
  EXPECT_EQ(reader.big<std::uint32_t>(), crc32(header));
  ByteReader fields(header.subspan(4));
  EXPECT_EQ(fields.big<std::uint32_t>(), 300U);
  EXPECT_EQ(fields.big<std::uint32_t>(), 7U);
}

TEST(Png, RefusesPicturesThatAreNone) {
  EXPECT_EQ(encode_png(Image()).error().code, ErrorCode::out_of_range);
  Image short_of_pixels(4, 4);
  short_of_pixels.rgb.pop_back();
  EXPECT_EQ(encode_png(short_of_pixels).error().code, ErrorCode::out_of_range);
}

TEST(Png, IsWrittenWholeOrNotAtAll) {
  const mien::test::Folder folder;
  const auto path = folder / "image.png";
  ASSERT_TRUE(write_png(path, Image(8, 8)).has_value());
  EXPECT_EQ(read_file(path).value(), encode_png(Image(8, 8)).value());
  EXPECT_FALSE(write_png("/nowhere/at/all.png", Image(8, 8)).has_value());
}

}  // namespace
}  // namespace mien::render::image_test
