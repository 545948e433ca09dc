#include "mien/headset/picture_decoder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "mien/core/random.h"
#include "mien/headset/jpeg_gate.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::picture_decoder_test {
namespace {

using namespace test;

class Decoder : public ::testing::Test {
 protected:
  struct Copy {
    int width = 0, height = 0;
    std::vector<std::uint8_t> pixels;
    bool operator==(const Copy&) const = default;
  };
  std::expected<Copy, PictureFault> decoded(const Bytes& jpeg, int width = 9999, int height = 9999) {
    const auto grey = decoder.decode(jpeg, width, height);
    if (!grey) return std::unexpected(grey.error());
    EXPECT_EQ(grey->pixels.size(), static_cast<std::size_t>(grey->width * grey->height));
    return Copy{grey->width, grey->height, {grey->pixels.begin(), grey->pixels.end()}};
  }
  PictureDecoder decoder = PictureDecoder::create().value();
};

TEST_F(Decoder, GivesThePictureThatWasTaken) {
  const std::vector<std::uint8_t> truth = rings(240, 240, 3);
  for (const Bytes& jpeg : {grey_jpeg(240, 240, 3, 95), colour_jpeg(240, 240, 3)}) {
    const auto got = decoded(jpeg);
    ASSERT_TRUE(got) << name_of(got.error());
    ASSERT_EQ(got->pixels.size(), truth.size());
    double error = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) error += std::abs(got->pixels[i] - truth[i]);
    EXPECT_LT(error / static_cast<double>(truth.size()), 1.5);
  }
}

TEST_F(Decoder, TakesTheSmallestSizeThatIsLargeEnough) {
  const Bytes jpeg = grey_jpeg(240, 180, 1);
  struct Case {
    int least_width, least_height, width, height;
  };
  for (const Case& one : {Case{96, 0, 120, 90},
                          {96, 96, 240, 180},
                          {60, 45, 60, 45},
                          {61, 1, 120, 90},
                          {1, 46, 120, 90},
                          {1, 1, 30, 23},
                          {0, 0, 30, 23},
                          {240, 180, 240, 180},
                          {300, 10, 240, 180},
                          {-5, -5, 30, 23}}) {
    const auto got = decoded(jpeg, one.least_width, one.least_height);
    ASSERT_TRUE(got);
    EXPECT_EQ(got->width, one.width) << one.least_width;
    EXPECT_EQ(got->height, one.height) << one.least_height;
  }
  for (int side = 1; side <= 20; ++side) {
    const auto got = decoded(grey_jpeg(side, 2 * side, 1), 3, 5);
    ASSERT_TRUE(got) << side;
    EXPECT_TRUE(got->width >= 3 || got->width == side);
  }
}

TEST_F(Decoder, MadeSmallerItIsTheMeanOfWhatItShows) {
  std::vector<std::uint8_t> grey(64 * 64);
  for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = i % 64 < 32 ? 40 : 200;
  const auto jpeg = render::encode_jpeg(64, 64, render::JpegPixels::grey, 95, grey).value();
  const auto got = decoded(jpeg, 8, 8);
  ASSERT_TRUE(got);
  ASSERT_EQ(got->width, 8);
  EXPECT_NEAR(got->pixels[8 + 1], 40, 3);
  EXPECT_NEAR(got->pixels[8 + 6], 200, 3);
}

TEST_F(Decoder, SameBitsWhicheverPictureCameBefore) {
  const Bytes jpeg = colour_jpeg(100, 60, 2);
  const auto first = decoded(jpeg, 50, 30);
  ASSERT_TRUE(first);
  static_cast<void>(decoded(grey_jpeg(240, 240, 1, 20)));
  static_cast<void>(decoded(Bytes(jpeg.begin(), jpeg.end() - 20)));
  Bytes damaged = jpeg;
  for (std::size_t i = place_of(jpeg, 0xDA) + 20; i < jpeg.size() - 40; i += 7) damaged[i] = std::byte{0x55};
  static_cast<void>(decoded(damaged));
  EXPECT_EQ(decoded(jpeg, 50, 30), first);
  PictureDecoder other = PictureDecoder::create().value();
  const auto again = other.decode(jpeg, 50, 30);
  ASSERT_TRUE(again);
  EXPECT_TRUE(std::ranges::equal(again->pixels, first->pixels));
}

TEST_F(Decoder, RefusesEveryTruncation) {
  const Bytes jpeg = grey_jpeg(40, 40, 1);
  for (std::size_t size = 0; size < jpeg.size(); ++size) {
    Bytes cut(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(decoded(cut), std::unexpected(PictureFault::truncated)) << size;
    // Its end put on again: then it is libjpeg's to see that coded data are missing.
    if (size < place_of(jpeg, 0xDA) + 12 || size + 3 > jpeg.size()) continue;
    if (cut.back() == std::byte{0xFF}) continue;
    cut += text_bytes("\xFF\xD9");
    EXPECT_FALSE(decoded(cut)) << size;
  }
}

TEST_F(Decoder, DamageIsRefusedOrGivesAPictureOfItsSize) {
  Random random(3);
  const Bytes jpeg = colour_jpeg(80, 80, 1);
  int refused = 0;
  for (int i = 0; i < 500; ++i) {
    Bytes damaged = jpeg;
    for (int j = 0; j < 3; ++j)
      damaged[random.below(damaged.size())] = static_cast<std::byte>(random.below(256));
    const auto header = check_jpeg(damaged);
    const auto got = decoded(damaged);
    if (!got) ++refused;
    if (got) {
      EXPECT_EQ(got->width, header->width);
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_TRUE(decoded(jpeg));
}

}  // namespace
}  // namespace mien::headset::picture_decoder_test
