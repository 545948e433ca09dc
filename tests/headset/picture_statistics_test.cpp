#include "mien/headset/picture_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "mien/core/random.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::picture_statistics_test {
namespace {

PictureStatistics of(int width, int height, const std::vector<std::uint8_t>& pixels) {
  return statistics_of({width, height, pixels});
}

TEST(PictureStatistics, AreThoseOfTheLevels) {
  std::vector<std::uint8_t> pixels(100, 100);
  for (int i = 0; i < 10; ++i) pixels[static_cast<std::size_t>(i)] = 255;
  for (int i = 10; i < 15; ++i) pixels[static_cast<std::size_t>(i)] = 5;
  pixels[15] = 250;
  pixels[16] = 249;
  pixels[17] = 6;
  const PictureStatistics s = of(10, 10, pixels);
  EXPECT_FLOAT_EQ(s.saturated, 0.11F);
  EXPECT_FLOAT_EQ(s.black, 0.05F);
  EXPECT_FLOAT_EQ(s.mean, static_cast<float>((10 * 255 + 5 * 5 + 250 + 249 + 6 + 82 * 100) / 25500.0));
  EXPECT_FLOAT_EQ(s.p2, 5.0F / 255);
  EXPECT_FLOAT_EQ(s.p98, 1);
}

TEST(PictureStatistics, PercentilesLeaveOutFewPixels) {
  std::vector<std::uint8_t> pixels(1000);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = i < 19 ? 0 : i < 21 ? 40 : i >= 981 ? 255 : 200;
  const PictureStatistics s = of(100, 10, pixels);
  EXPECT_FLOAT_EQ(s.p2, 40.0F / 255);
  EXPECT_FLOAT_EQ(s.p98, 200.0F / 255);
}

TEST(PictureStatistics, SharpnessIsOneOfNoiseAndLessOfWhatIsSmooth) {
  Random random(1);
  std::vector<std::uint8_t> noise(200 * 200);
  for (std::uint8_t& pixel : noise) pixel = static_cast<std::uint8_t>(random.below(256));
  EXPECT_NEAR(of(200, 200, noise).sharpness, 1, 0.03);
  std::vector<std::uint8_t> chess(200 * 200);
  for (std::size_t i = 0; i < chess.size(); ++i) chess[i] = (i / 200 + i) % 2 == 0 ? 10 : 200;
  EXPECT_NEAR(of(200, 200, chess).sharpness, 3.2, 0.01);
  // Squares with hard edges; the same blurred over 5 x 5, and at half the light.
  std::vector<std::uint8_t> sharp(200 * 200);
  for (std::size_t i = 0; i < sharp.size(); ++i) sharp[i] = (i / 200 / 10 + i % 200 / 10) % 2 == 0 ? 20 : 220;
  std::vector<std::uint8_t> blurred = sharp;
  std::vector<std::uint8_t> dark = sharp;
  for (std::size_t y = 2; y < 198; ++y)
    for (std::size_t x = 2; x < 198; ++x) {
      int sum = 0;
      for (std::size_t v = y - 2; v <= y + 2; ++v)
        for (std::size_t u = x - 2; u <= x + 2; ++u) sum += sharp[v * 200 + u];
      blurred[y * 200 + x] = static_cast<std::uint8_t>(sum / 25);
    }
  for (std::uint8_t& pixel : dark) pixel = static_cast<std::uint8_t>(pixel / 2);
  const float is = of(200, 200, sharp).sharpness;
  EXPECT_GT(is, 0.02);
  EXPECT_LT(of(200, 200, blurred).sharpness, 0.2F * is);
  EXPECT_NEAR(of(200, 200, dark).sharpness / is, 1, 1e-5) << "exposure is not sharpness";
}

TEST(PictureStatistics, OfSmallAndFlatPicturesAreNumbers) {
  EXPECT_EQ(of(0, 0, {}), PictureStatistics());
  for (const int side : {1, 2, 3, 20}) {
    const PictureStatistics s =
        of(side, side, std::vector<std::uint8_t>(static_cast<std::size_t>(side * side), 77));
    EXPECT_EQ(s.sharpness, 0);
    EXPECT_FLOAT_EQ(s.p2, 77.0F / 255);
    EXPECT_FLOAT_EQ(s.p98, 77.0F / 255);
    EXPECT_FLOAT_EQ(s.mean, 77.0F / 255);
  }
  // The largest picture, with the largest differences: no sum overflows.
  std::vector<std::uint8_t> chess(1280 * 960);
  for (std::size_t i = 0; i < chess.size(); ++i) chess[i] = (i / 1280 + i) % 2 == 0 ? 0 : 255;
  EXPECT_NEAR(of(1280, 960, chess).sharpness, 3.2, 0.001);
}

TEST(PictureStatistics, TheHashKnowsEachPixelAndTheSize) {
  std::vector<std::uint8_t> pixels = test::rings(30, 20, 1);
  const std::uint64_t hash = of(30, 20, pixels).hash;
  EXPECT_EQ(of(30, 20, pixels).hash, hash);
  EXPECT_NE(of(20, 30, pixels).hash, hash);
  for (std::uint8_t& pixel : pixels) {
    pixel ^= 1U;
    EXPECT_NE(of(30, 20, pixels).hash, hash);
    pixel ^= 1U;
  }
  std::swap(pixels[0], pixels[16]);
  EXPECT_NE(of(30, 20, pixels).hash, hash);
}

TEST(FrozenPictures, AreThreeOfOneContentInARow) {
  FrozenPictures frozen;
  EXPECT_FALSE(frozen.add(0));
  EXPECT_FALSE(frozen.add(0));
  EXPECT_FALSE(frozen.add(1));
  EXPECT_FALSE(frozen.add(1));
  EXPECT_TRUE(frozen.add(1));
  EXPECT_TRUE(frozen.add(1));
  EXPECT_FALSE(frozen.add(2));
  EXPECT_FALSE(frozen.add(2));
  frozen.restart();
  EXPECT_FALSE(frozen.add(2));
  EXPECT_FALSE(frozen.add(2));
  EXPECT_TRUE(frozen.add(2));
}

}  // namespace
}  // namespace mien::headset::picture_statistics_test
