#include "mien/headset/view_maker.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/headset/small_jpeg.h"

namespace mien::headset::test::view_maker_test {
namespace {

constexpr std::size_t kSide = 96;
constexpr NetworkViewSettings kCropped = {
    .side = kSide, .left = 0.1, .top = 0.18, .right = 0.92, .bottom = 1};

std::vector<std::uint8_t> view_of(ViewMaker& views, const Bytes& jpeg, const NetworkViewSettings& settings) {
  std::vector<std::uint8_t> pixels(kSide * kSide);
  EXPECT_TRUE(views.make(jpeg, settings, pixels));
  return pixels;
}

TEST(ViewMaker, ShowsThePartThatTheNetworkSees) {
  ViewMaker views = ViewMaker::create().value();
  const Bytes jpeg = grey_jpeg(240, 240, 3);
  const std::vector<std::uint8_t> grey = rings(240, 240, 3);
  const std::vector<std::uint8_t> view = view_of(views, jpeg, kCropped);
  // Against the picture itself: as the rings go, bright where it is bright, in 9 of 10 places.
  int alike = 0;
  int compared = 0;
  for (std::size_t y = 4; y < kSide; y += 8)
    for (std::size_t x = 4; x < kSide; x += 8) {
      const auto at = [](std::size_t i, double from, double to) {
        return static_cast<std::size_t>(240 * (from + (to - from) * (static_cast<double>(i) + 0.5) / kSide));
      };
      const int there = grey[240 * at(y, 0.18, 1) + at(x, 0.1, 0.92)];
      if (std::abs(there - 128) < 40) continue;
      ++compared;
      alike += (view[kSide * y + x] > 127) == (there > 128) ? 1 : 0;
    }
  EXPECT_GT(compared, 60);
  EXPECT_GT(alike, 9 * compared / 10);
}

TEST(ViewMaker, TurnsAndMirrorsAsItIsTold) {
  ViewMaker views = ViewMaker::create().value();
  const Bytes jpeg = grey_jpeg(240, 180, 5);
  NetworkViewSettings settings = kCropped;
  const auto straight = view_of(views, jpeg, settings);
  settings.mirror = true;
  const auto mirrored = view_of(views, jpeg, settings);
  settings = kCropped;
  settings.quarter_turns = 1;
  const auto turned = view_of(views, jpeg, settings);
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t x = 0; x < kSide; ++x) {
      ASSERT_EQ(mirrored[kSide * y + x], straight[kSide * y + (kSide - 1 - x)]);
      ASSERT_EQ(turned[kSide * x + (kSide - 1 - y)], straight[kSide * y + x]);
    }
  EXPECT_EQ(view_of(views, jpeg, kCropped), straight) << "as before, whatever was wanted meanwhile";
}

TEST(ViewMaker, RefusesWhatIsNoPictureAndNoView) {
  ViewMaker views = ViewMaker::create().value();
  std::vector<std::uint8_t> pixels(kSide * kSide);
  Bytes jpeg = grey_jpeg(64, 64, 1);
  NetworkViewSettings wrong = kCropped;
  wrong.right = wrong.left;
  EXPECT_FALSE(views.make(jpeg, wrong, pixels));
  wrong.right = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(views.make(jpeg, wrong, pixels));
  EXPECT_TRUE(views.make(jpeg, kCropped, pixels));
  jpeg.resize(jpeg.size() / 2);
  EXPECT_FALSE(views.make(jpeg, kCropped, pixels));
  EXPECT_FALSE(views.make({}, kCropped, pixels));
}

}  // namespace
}  // namespace mien::headset::test::view_maker_test
