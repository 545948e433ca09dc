#include "mien/render/lettering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

namespace mien::render::lettering_test {
namespace {

const Lettering& lettering() {
  static const Lettering kLettering = Lettering::load().value();
  return kLettering;
}

int inked(const Image& picture) {
  int count = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) count += picture.rgb[i] > 0 ? 1 : 0;
  return count;
}

TEST(Lettering, EveryPrintableCharacterHasALookOfItsOwn) {
  std::set<std::vector<std::uint8_t>> looks;
  for (char c = '!'; c <= '~'; ++c) {
    Image picture(40, 60);
    lettering().draw(picture, std::string(1, c), 8, 40, 30, {255, 255, 255});
    EXPECT_GT(inked(picture), 3) << c;
    looks.insert(picture.rgb);
  }
  EXPECT_EQ(looks.size(), 94U);
}

TEST(Lettering, CapitalsStandOnTheBaselineAndAreSevenTenthsHigh) {
  Image picture(40, 60);
  lettering().draw(picture, "H", 8, 40, 30, {255, 255, 255});
  int top = 60, bottom = -1;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 40; ++x)
      if (picture.pixel(x, y)[0] > 128) {
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
  EXPECT_NEAR(top, 40 - 21, 2);
  EXPECT_NEAR(bottom, 40, 2);
}

TEST(Lettering, AlignmentPlacesTheLine) {
  const auto left_edge = [](Align align) {
    Image picture(200, 40);
    lettering().draw(picture, "HHH", 100, 30, 20, {255, 255, 255}, align);
    for (int x = 0; x < 200; ++x)
      for (int y = 0; y < 40; ++y)
        if (picture.pixel(x, y)[0] > 0) return x;
    return -1;
  };
  const float width = lettering().width("HHH", 20);
  EXPECT_NEAR(left_edge(Align::left) - left_edge(Align::right), width, 2);
  EXPECT_NEAR(left_edge(Align::left) - left_edge(Align::centre), width / 2, 2);
}

TEST(Lettering, WhatFallsOutsideIsLeftOut) {
  Image picture(20, 20);
  lettering().draw(picture, "Mien was here, and further", -30, 15, 16, {255, 255, 255});
  lettering().draw(picture, "Mien", 5, 400, 16, {255, 255, 255});
  lettering().draw(picture, "Mien", 5, -400, 16, {255, 255, 255});
  EXPECT_GT(inked(picture), 0);
  lettering().draw(picture, "", 0, 0, 16, {255, 255, 255});
  EXPECT_EQ(lettering().width("", 16), 0);
}

TEST(Lettering, AMissingFontNamesItsPackage) {
  const auto missing = Lettering::load("no/such/font.ttf");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  EXPECT_NE(missing.error().fix.find("fonts-dejavu-core"), std::string::npos);
  const auto no_font = Lettering::load("/proc/self/exe");
  ASSERT_FALSE(no_font);
  EXPECT_EQ(no_font.error().code, ErrorCode::unsupported);
}

TEST(Lettering, OtherCharactersShowAsABox) {
  Image known(40, 40), unknown(40, 40);
  lettering().draw(known, "\x01", 5, 30, 20, {255, 255, 255});
  lettering().draw(unknown, "\xFF", 5, 30, 20, {255, 255, 255});
  EXPECT_GT(inked(known), 20);
  EXPECT_EQ(known, unknown);
}

}  // namespace
}  // namespace mien::render::lettering_test
