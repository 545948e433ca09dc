#include "mien/headset/network_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mien/core/random.h"
#include "tests/allocation_count.h"
#include "tests/headset/small_jpeg.h"

namespace mien::headset::network_view_test {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

std::vector<float> view_of(const NetworkViewSettings& settings, int width, int height,
                           const std::vector<std::uint8_t>& pixels) {
  NetworkView view = NetworkView::create(settings).value();
  std::vector<float> out(static_cast<std::size_t>(settings.side * settings.side));
  view.make({width, height, pixels}, out);
  return out;
}

/// Of a picture whose levels reach from 0 to 255 at its own size: then nothing is stretched.
TEST(NetworkView, OfItsOwnSizeIsThePicture) {
  std::vector<std::uint8_t> pixels(64);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(255 * i / 63);
  // 2 % of 64 are 1.28 pixels: the levels of the second and of the last but one are 0 and 1.
  const auto view = view_of({.side = 8}, 8, 8, pixels);
  for (std::size_t i = 1; i < 63; ++i)
    EXPECT_NEAR(view[i],
                static_cast<float>(pixels[i] - pixels[1]) / static_cast<float>(pixels[62] - pixels[1]), 1e-5)
        << i;
  EXPECT_EQ(view.front(), 0);
  EXPECT_EQ(view.back(), 1);
}

TEST(NetworkView, APixelIsTheMeanOfWhatItCovers) {
  // Six columns into four: each covers one and a half of them.
  const std::vector<std::uint8_t> row = {0, 60, 90, 120, 180, 240};
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < 4; ++i) pixels.insert(pixels.end(), row.begin(), row.end());
  const auto view = view_of({.side = 4}, 6, 4, pixels);
  const std::vector<double> means = {(0 + 30) / 1.5, (30 + 90) / 1.5, (120 + 90) / 1.5, (90 + 240) / 1.5};
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 4; ++x)
      EXPECT_NEAR(view[4 * y + x], (means[x] - means[0]) / (means[3] - means[0]), 1e-5) << x;
}

TEST(NetworkView, MadeLargerRepeatsPixels) {
  const auto view = view_of({.side = 4}, 2, 2, {0, 255, 102, 51});
  EXPECT_THAT(view, ElementsAre(0, 0, 1, 1, 0, 0, 1, 1, testing::FloatNear(0.4F, 1e-5),
                                testing::FloatNear(0.4F, 1e-5), testing::FloatNear(0.2F, 1e-5),
                                testing::FloatNear(0.2F, 1e-5), testing::FloatNear(0.4F, 1e-5),
                                testing::FloatNear(0.4F, 1e-5), testing::FloatNear(0.2F, 1e-5),
                                testing::FloatNear(0.2F, 1e-5)));
}

TEST(NetworkView, TurnsClockwiseAndThenMirrors) {
  // 1 2
  // 3 4
  const std::vector<std::uint8_t> pixels = {0, 85, 170, 255};
  const auto corners = [&](int turns, bool mirror) {
    std::vector<int> out;
    for (const float level : view_of({.side = 2, .quarter_turns = turns, .mirror = mirror}, 2, 2, pixels))
      out.push_back(static_cast<int>(std::lround(1 + 3 * level)));
    return out;
  };
  EXPECT_THAT(corners(0, false), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(corners(1, false), ElementsAre(3, 1, 4, 2));
  EXPECT_THAT(corners(2, false), ElementsAre(4, 3, 2, 1));
  EXPECT_THAT(corners(3, false), ElementsAre(2, 4, 1, 3));
  EXPECT_THAT(corners(0, true), ElementsAre(2, 1, 4, 3));
  EXPECT_THAT(corners(1, true), ElementsAre(1, 3, 2, 4));
  EXPECT_THAT(corners(2, true), ElementsAre(3, 4, 1, 2));
  EXPECT_THAT(corners(3, true), ElementsAre(4, 2, 3, 1));
}

TEST(NetworkView, AMirroredPictureGivesTheMirroredViewToTheBit) {
  const std::vector<std::uint8_t> pixels = test::rings(96, 96, 2);
  std::vector<std::uint8_t> mirrored = pixels;
  for (auto row = mirrored.begin(); row != mirrored.end(); row += 96) std::reverse(row, row + 96);
  EXPECT_EQ(view_of({.side = 48}, 96, 96, pixels), view_of({.side = 48, .mirror = true}, 96, 96, mirrored));
}

TEST(NetworkView, SeesWhatIsCutOut) {
  std::vector<std::uint8_t> pixels(100 * 50, 255);
  std::vector<std::uint8_t> part;
  for (std::size_t y = 0; y < 20; ++y)
    for (std::size_t x = 0; x < 20; ++x) {
      const auto level = static_cast<std::uint8_t>(5 * x + 6 * y);
      pixels[(y + 10) * 100 + x + 40] = level;
      part.push_back(level);
    }
  const auto cut =
      view_of({.side = 20, .left = 0.4, .top = 0.2, .right = 0.6, .bottom = 0.6}, 100, 50, pixels);
  const auto whole = view_of({.side = 20}, 20, 20, part);
  for (std::size_t i = 0; i < cut.size(); ++i) EXPECT_NEAR(cut[i], whole[i], 1e-5);
}

TEST(NetworkView, DoesNotDependOnExposure) {
  std::vector<std::uint8_t> bright = test::rings(120, 120, 1);
  std::vector<std::uint8_t> dark = bright;
  for (std::uint8_t& pixel : dark) pixel = static_cast<std::uint8_t>(pixel / 4 + 10);
  const auto one = view_of({.side = 40}, 120, 120, bright);
  const auto other = view_of({.side = 40}, 120, 120, dark);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(one[i], other[i], 0.06);
}

TEST(NetworkView, WithoutContrastIsGreyAllOver) {
  Random random(1);
  std::vector<std::uint8_t> covered(100 * 100);
  for (std::uint8_t& pixel : covered) pixel = static_cast<std::uint8_t>(8 + random.below(3));
  EXPECT_THAT(view_of({.side = 50}, 100, 100, covered), Each(0.5F));
  EXPECT_THAT(view_of({.side = 50}, 100, 100, std::vector<std::uint8_t>(100 * 100, 0)), Each(0.5F));
  EXPECT_THAT(view_of({.side = 1}, 1, 1, {200}), Each(0.5F));
}

TEST(NetworkView, InStepsIsTheSameRounded) {
  const std::vector<std::uint8_t> pixels = test::rings(240, 240, 1);
  NetworkView view = NetworkView::create({.side = 96}).value();
  std::vector<float> shares(96 * 96);
  std::vector<std::uint8_t> steps(96 * 96);
  view.make({240, 240, pixels}, shares);
  view.make({240, 240, pixels}, steps);
  for (std::size_t i = 0; i < steps.size(); ++i) EXPECT_NEAR(shares[i] * 255, steps[i], 0.501);
}

TEST(NetworkView, IsRightForEverySizeInTurnAndAllocatesNothing) {
  NetworkView view =
      NetworkView::create({.side = 32, .left = 0.1, .top = 0.05, .right = 0.95, .bottom = 1}).value();
  struct Size {
    int width, height;
  };
  for (const Size size : {Size{1280, 960}, {240, 240}, {1, 1}, {7, 960}, {1280, 3}, {33, 31}}) {
    const std::vector<std::uint8_t> pixels = test::rings(size.width, size.height, 1);
    std::vector<float> one(32 * 32);
    std::vector<float> other(32 * 32);
    const std::size_t before = mien::test::allocation_count();
    view.make({size.width, size.height, pixels}, one);
    EXPECT_EQ(mien::test::allocation_count(), before);
    NetworkView fresh = NetworkView::create(view.settings()).value();
    fresh.make({size.width, size.height, pixels}, other);
    EXPECT_EQ(one, other) << size.width;
  }
}

TEST(NetworkView, RefusesEachWrongSetting) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const NetworkViewSettings& wrong : std::vector<NetworkViewSettings>{{.side = 0},
                                                                           {.side = 513},
                                                                           {.left = -0.1},
                                                                           {.left = none},
                                                                           {.left = 0.6, .right = 0.4},
                                                                           {.right = 1.1},
                                                                           {.right = none},
                                                                           {.top = -0.1},
                                                                           {.top = 1},
                                                                           {.bottom = 2},
                                                                           {.bottom = none},
                                                                           {.quarter_turns = -1},
                                                                           {.quarter_turns = 4}}) {
    const auto view = NetworkView::create(wrong);
    ASSERT_FALSE(view);
    EXPECT_EQ(view.error().code, ErrorCode::out_of_range);
  }
}

}  // namespace
}  // namespace mien::headset::network_view_test
