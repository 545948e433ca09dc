#include "mien/render/raster.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "mien/render/hair_fragments.h"

namespace mien::render::raster_test {
namespace {

constexpr PixelBox kPicture = {0, 0, 64, 64};

ScreenPoint point(int x, int y, float inverse_depth = 1) {
  return {.x = x, .y = y, .inverse_depth = inverse_depth};
}

using Count = std::map<std::array<int, 3>, int>;  // Of pixel x, y and sample.

void count(const ScreenTriangle& triangle, Count* times) {
  triangle.scan(kPicture, [&](int x, int y, Coverage coverage) {
    for (int s = 0; s < kSamples; ++s)
      if ((coverage >> s & 1U) != 0) ++(*times)[{x, y, s}];
  });
}

TEST(Raster, TrianglesAroundAPointCoverEachSampleOnce) {
  std::mt19937 random(3);
  for (int round = 0; round < 50; ++round) {
    // A square, fanned out from a point inside, in either direction of turning.
    const int x = 100 + static_cast<int>(random() % 600), y = 100 + static_cast<int>(random() % 600);
    const std::array<ScreenPoint, 4> corner = {point(32, 48), point(960, 48), point(960, 976),
                                               point(32, 976)};
    Count times;
    for (std::size_t k = 0; k < 4; ++k)
      count(k % 2 == 0 ? ScreenTriangle(point(x, y), corner[k], corner[(k + 1) % 4])
                       : ScreenTriangle(point(x, y), corner[(k + 1) % 4], corner[k]),
            &times);
    EXPECT_EQ(times.size(), std::size_t{58 * 58 * kSamples});
    for (const auto& [sample, how_often] : times) EXPECT_EQ(how_often, 1) << sample[0] << ' ' << sample[1];
  }
}

TEST(Raster, LargeTrianglesCoverWhatSmallOnesDo) {
  // Its edge functions take 64 bits, and it covers the whole picture.
  Count times;
  count(ScreenTriangle(point(-1'000'000, -900'000), point(3'000'000, -900'000), point(-1'000'000, 2'900'000)),
        &times);
  EXPECT_EQ(times.size(), std::size_t{64 * 64 * kSamples});
}

TEST(Raster, DegenerateAndInvisibleTrianglesCoverNothing) {
  Count times;
  count(ScreenTriangle(point(0, 0), point(160, 160), point(320, 320)), &times);
  count(ScreenTriangle(point(0, 0), point(160, 0), point(0, 160, 0)), &times);
  EXPECT_TRUE(times.empty());
}

TEST(Raster, WeightsAreThoseOfPerspective) {
  // An edge from 1 m to 3 m away: half way on the screen is a quarter of the way along it.
  const ScreenTriangle triangle(point(0, 0, 1), point(320, 0, 1.0F / 3), point(0, 320, 1));
  const auto weight = triangle.weights(10, 0);
  EXPECT_NEAR(weight[0], 0.75F, 1e-5F);
  EXPECT_NEAR(weight[1], 0.25F, 1e-5F);
  const Eigen::Vector2f slope = triangle.gradient({0, 40, 20});
  EXPECT_NEAR(slope.x(), 2, 1e-5F);
  EXPECT_NEAR(slope.y(), 1, 1e-5F);
}

TEST(Raster, TheNearestTriangleIsSeen) {
  TileDepths depths;
  depths.clear(0, 0);
  EXPECT_TRUE(depths.empty());
  depths.draw(4, ScreenTriangle(point(0, 0, 1), point(512, 0, 1), point(0, 512, 1)));
  // Stands through the first one: nearer on the left, farther on the right.
  depths.draw(9, ScreenTriangle(point(0, 0, 2), point(320, 0, 0.5F), point(0, 320, 2)));
  EXPECT_FALSE(depths.empty());
  EXPECT_EQ(depths.triangle(2, 2, 0), 9U);
  EXPECT_EQ(depths.triangle(17, 1, 0), 4U);
  EXPECT_EQ(depths.triangle(31, 31, 0), TileDepths::kNothing);
}

TEST(Raster, BinsNameEveryTileThatATriangleTouches) {
  const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {3, 4, 5}, {0, 1, 6}};
  const std::vector<ScreenPoint> points = {point(0, 0),        point(40 * 16, 0),  point(0, 40 * 16),
                                           point(70 * 16, 16), point(80 * 16, 16), point(70 * 16, 99),
                                           point(0, 0, 0)};
  TileBins bins;
  bins.sort(std::vector<std::uint32_t>{0, 1, 2}, triangles, points, 100, 64);
  ASSERT_EQ(bins.count(), 8U);
  for (const std::size_t tile : {0U, 1U, 4U, 5U}) {
    ASSERT_EQ(bins.of(tile).size(), 1U) << tile;
    EXPECT_EQ(bins.of(tile)[0], 0U);
  }
  ASSERT_EQ(bins.of(2).size(), 1U);
  EXPECT_EQ(bins.of(2)[0], 1U);
  for (const std::size_t tile : {3U, 6U, 7U}) EXPECT_TRUE(bins.of(tile).empty()) << tile;
}

TEST(Raster, TheMiddleOfAllSamplesIsThePixels) {
  EXPECT_EQ(middle_of(kWholePixel), Eigen::Vector2f(0.5F, 0.5F));
  EXPECT_EQ(count_of(0b1010), 2);
}

TEST(HairFragments, AreSortedByDepthAndWhatIsHiddenIsDropped) {
  TileHair hair;
  const auto add = [&](int pixel, float inverse_depth, float cover, Coverage samples) {
    hair.add({.inverse_depth = inverse_depth,
              .cover = cover,
              .light = Vec3f::Ones(),
              .pixel = static_cast<std::uint16_t>(pixel),
              .samples = static_cast<std::uint8_t>(samples)});
  };
  add(7, 1, 0.5F, kWholePixel);
  add(7, 3, 0.5F, kWholePixel);
  add(9, 1, 1, 0b0011);
  add(9, 2, 1, 0b0001);
  add(7, 2, 1, kWholePixel);
  add(9, 0.5F, 1, 0b0010);
  hair.sort();
  ASSERT_EQ(hair.of(7).size(), 2U) << "the opaque one hides the last";
  EXPECT_EQ(hair.of(7)[0].inverse_depth, 3);
  EXPECT_EQ(hair.of(7)[1].inverse_depth, 2);
  EXPECT_TRUE(hair.of(8).empty());
  ASSERT_EQ(hair.of(9).size(), 2U) << "hidden at its only sample";
  EXPECT_EQ(hair.of(9)[1].inverse_depth, 1);
}

}  // namespace
}  // namespace mien::render::raster_test
