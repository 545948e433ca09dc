#include "mien/render/strands.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::render::strands_test {
namespace {

float covered(float v, float width) {
  constexpr int kSteps = 64 * 32;
  float sum = 0;
  for (int i = 0; i < kSteps; ++i)
    sum += strand_at({(static_cast<float>(i) + 0.5F) / kSteps, v}, width).cover;
  return sum / kSteps;
}

TEST(Strands, RepeatAtEveryWholeUnit) {
  for (int i = 0; i < 200; ++i) {
    const float u = static_cast<float>(i) / 256, v = static_cast<float>(i % 11) / 10;
    const Strand a = strand_at({u, v}, 0.2F), b = strand_at({u + 5, v}, 0.2F);
    EXPECT_NEAR(a.cover, b.cover, 1e-4F);
    EXPECT_NEAR(a.brightness, b.brightness, 1e-2F);
  }
}

TEST(Strands, CoverMostInTheMiddleAndNothingBeyondTheTip) {
  EXPECT_GT(covered(0.4F, 0.1F), 0.4F);
  EXPECT_LT(covered(0.4F, 0.1F), 0.9F) << "skin is seen between hairs";
  EXPECT_LT(covered(0.9F, 0.1F), covered(0.4F, 0.1F));
  EXPECT_EQ(covered(1.0F, 0.1F), 0);
  EXPECT_LT(covered(0.0F, 0.1F), 0.2F) << "they begin at different places";
}

TEST(Strands, WiderPixelsCoverAsMuch) {
  // Farther away the same hair is a blur of the same amount, and of the whole ribbon one amount everywhere.
  for (const float width : {0.5F, 1.4F, 5.0F, 30.0F})
    EXPECT_NEAR(covered(0.4F, width), covered(0.4F, 0.1F), 0.01F);
  const float everywhere = covered(0.4F, 0.1F);
  for (int i = 0; i < 64; ++i)
    EXPECT_NEAR(strand_at({static_cast<float>(i) / 64, 0.4F}, 32).cover, everywhere, 0.05F) << i;
}

TEST(Strands, ThePictureIsOneUnit) {
  const auto png = strands_png();
  ASSERT_TRUE(png);
  EXPECT_LT(png->size(), 200'000U);
  EXPECT_EQ(static_cast<unsigned char>((*png)[1]), 'P');
}

TEST(Strands, HairIsRoundedAndTheRestKeepsItsNormals) {
  const std::vector<Vec3f> vertices = {Vec3f(0, 1, 0), Vec3f(0, 1, 0), Vec3f(0, 1, 0)};
  std::vector<Vec3f> normals = {Vec3f::UnitX(), Vec3f::UnitX(), -Vec3f::UnitY()};
  round_hair(vertices, {false, true, true}, Vec3f::Zero(), normals);
  EXPECT_EQ(normals[0], Vec3f::UnitX());
  EXPECT_GT(normals[1].y(), 0.5F);
  EXPECT_NEAR(normals[1].norm(), 1, 1e-6);
  EXPECT_NEAR(normals[2].y(), 1, 1e-6) << "the side that looks into the head is turned out";
}

}  // namespace
}  // namespace mien::render::strands_test
