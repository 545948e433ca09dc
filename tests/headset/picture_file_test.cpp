#include "mien/headset/picture_file.h"

#include <gmock/gmock.h>

#include "tests/headset/small_jpeg.h"

namespace mien::headset::picture_file_test {
namespace {

using test::text_bytes;
using testing::HasSubstr;
using Pixels = std::vector<std::uint8_t>;

ErrorCode refused(const std::string& text) {
  const auto picture = parse_picture(text_bytes(text), "p.pgm");
  EXPECT_FALSE(picture) << text;
  if (picture) return ErrorCode::internal;
  EXPECT_THAT(picture.error().message(), HasSubstr("p.pgm"));
  return picture.error().code;
}

PictureCopy parsed(const std::string& text) {
  const auto picture = parse_picture(text_bytes(text), "p.pgm");
  EXPECT_TRUE(picture) << picture.error().message();
  return picture.value_or(PictureCopy());
}

TEST(PictureFile, ReadsEachKindOfNetpbm) {
  EXPECT_EQ(parsed("P5\n# who made it\n2 1\n255\nAB"), (PictureCopy{2, 1, Pixels{'A', 'B'}}));
  EXPECT_EQ(parsed("P2 3 1 # a comment\n100\n0 50 100"), (PictureCopy{3, 1, Pixels{0, 128, 255}}));
  EXPECT_EQ(parsed(std::string("P5 1 2 65535\n\x80\x00\xFF\xFF", 17)), (PictureCopy{1, 2, Pixels{128, 255}}));
  EXPECT_EQ(parsed("P3 2 1 255 255 255 255  0 255 0"), (PictureCopy{2, 1, Pixels{255, 150}}));
  EXPECT_EQ(parsed("P6 1 1 255\nBBB"), (PictureCopy{1, 1, Pixels{'B'}}));
}

TEST(PictureFile, ReadsJpegsInGrey) {
  const auto grey = parse_picture(test::grey_jpeg(64, 48, 1, 95), "a.jpg");
  ASSERT_TRUE(grey) << grey.error().message();
  EXPECT_EQ(grey->width, 64);
  EXPECT_EQ(grey->height, 48);
  const auto colour = parse_picture(test::colour_jpeg(64, 48, 1), "b.jpg");
  ASSERT_TRUE(colour) << colour.error().message();
  const auto rings = test::rings(64, 48, 1);
  for (const PictureCopy* picture : {&*grey, &*colour}) {
    double apart = 0;
    for (std::size_t i = 0; i < rings.size(); ++i) apart += std::abs(picture->pixels[i] - rings[i]);
    EXPECT_LT(apart / static_cast<double>(rings.size()), 4);
  }
}

TEST(PictureFile, RefusesEachWrongPicture) {
  EXPECT_EQ(refused(""), ErrorCode::unsupported);
  EXPECT_EQ(refused("P"), ErrorCode::unsupported);
  EXPECT_EQ(refused("\x89PNG\r\n"), ErrorCode::unsupported);
  EXPECT_EQ(refused("P4\n8 1\n\xFF"), ErrorCode::unsupported) << "bits";
  EXPECT_EQ(refused("P5"), ErrorCode::unsupported);
  EXPECT_EQ(refused("P5\n"), ErrorCode::malformed);
  EXPECT_EQ(refused("P5\n2 x\n255\nAB"), ErrorCode::malformed);
  EXPECT_EQ(refused("P5\n-2 1\n255\nAB"), ErrorCode::malformed);
  EXPECT_EQ(refused("P5\n2 1\n# no end"), ErrorCode::malformed);
  EXPECT_EQ(refused("P5\n0 1\n255\n"), ErrorCode::out_of_range);
  EXPECT_EQ(refused("P5\n8193 1\n255\n"), ErrorCode::out_of_range);
  EXPECT_EQ(refused("P5\n1000000 1\n255\n"), ErrorCode::malformed) << "seven digits";
  EXPECT_EQ(refused("P5\n8192 8192\n255\nA"), ErrorCode::truncated) << "allocates nothing by its word";
  EXPECT_EQ(refused("P5\n1 1\n0\nA"), ErrorCode::out_of_range);
  EXPECT_EQ(refused("P5\n1 1\n65536\nA"), ErrorCode::out_of_range);
  EXPECT_EQ(refused("P5\n2 1\n255\nA"), ErrorCode::truncated);
  EXPECT_EQ(refused("P5\n1 1\n256\nA"), ErrorCode::truncated) << "16 bits a level";
  EXPECT_EQ(refused("P2\n2 1\n100\n0 101"), ErrorCode::malformed);
  EXPECT_EQ(refused("P2\n2 2\n100\n00000000 0 0 0"), ErrorCode::malformed);
}

TEST(PictureFile, RefusesAJpegCutAtAnyByte) {
  const test::Bytes jpeg = test::grey_jpeg(24, 16, 0);
  for (std::size_t size = 0; size + 2 < jpeg.size(); ++size)
    EXPECT_FALSE(parse_picture(std::span(jpeg).first(size), "cut.jpg")) << size;
}

TEST(PictureFile, ScalesByArea) {
  const Pixels four = {0, 100, 200, 100};
  EXPECT_EQ(scaled_picture({2, 2, four}, 1, 1), (PictureCopy{1, 1, Pixels{100}}));
  EXPECT_EQ(scaled_picture({4, 1, four}, 2, 1), (PictureCopy{2, 1, Pixels{50, 150}}));
  EXPECT_EQ(scaled_picture({2, 1, std::span(four).first(2)}, 4, 2),
            (PictureCopy{4, 2, Pixels{0, 0, 100, 100, 0, 0, 100, 100}}));
  // A pixel and a half each: (0 + 50) / 1.5 and (50 + 200) / 1.5.
  EXPECT_EQ(scaled_picture({3, 1, std::span(four).first(3)}, 2, 1), (PictureCopy{2, 1, Pixels{33, 167}}));
  EXPECT_EQ(scaled_picture({2, 2, four}, 2, 2).pixels, four);
}

}  // namespace
}  // namespace mien::headset::picture_file_test
