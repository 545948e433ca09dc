#include "mien/render/error_colours.h"

#include <gtest/gtest.h>

#include <limits>

#include "mien/render/tone.h"

namespace mien::render::error_colours_test {
namespace {

float luminance(const Vec3f& c) {
  return c.dot(Vec3f(0.2126F, 0.7152F, 0.0722F));
}

TEST(ErrorColour, DarkensAllTheWay) {
  for (int i = 0; i < 100; ++i)
    EXPECT_GT(luminance(error_colour(0.01F * static_cast<float>(i))),
              luminance(error_colour(0.01F * static_cast<float>(i + 1))));
}

TEST(ErrorColour, HoldsBeyondItsEndsAndNeverFails) {
  EXPECT_EQ(error_colour(-3), error_colour(0));
  EXPECT_EQ(error_colour(7), error_colour(1));
  EXPECT_EQ(error_colour(std::numeric_limits<float>::quiet_NaN()), error_colour(1));
}

TEST(ErrorLegend, StandsAtTheBottomAndSurvivesSmallPictures) {
  const Lettering lettering = Lettering::load().value();
  Image picture(400, 300);
  draw_error_legend(picture, lettering, 5e-3F, {255, 255, 255});
  for (int x = 0; x < 400; ++x) EXPECT_EQ(picture.pixel(x, 200)[0], 0);
  const Rgb first = to_srgb(error_colour(0));
  bool found = false;
  for (int y = 200; y < 300; ++y)
    found = found || std::equal(first.begin(), first.end(), picture.pixel(80, y));
  EXPECT_TRUE(found) << "the ramp begins at its palest";
  Image tiny(2, 2);
  draw_error_legend(tiny, lettering, 5e-3F, {255, 255, 255});
}

TEST(Tone, SrgbRoundTrip) {
  for (int i = 0; i < 256; ++i) {
    const auto grey = static_cast<std::uint8_t>(i);
    EXPECT_EQ(to_srgb(from_srgb({grey, grey, grey}))[1], grey);
  }
}

TEST(Tone, RisesAndNeverReachesOne) {
  float last = -1;
  for (int i = 0; i < 200; ++i) {
    const float out = tone_map(Vec3f::Constant(0.05F * static_cast<float>(i)))[0];
    EXPECT_GT(out, last);
    EXPECT_LT(out, 1);
    last = out;
  }
  EXPECT_FLOAT_EQ(tone_map(Vec3f::Constant(0.3F))[1], 0.3F);
}

}  // namespace
}  // namespace mien::render::error_colours_test
