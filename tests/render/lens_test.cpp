#include "mien/render/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace mien::render::lens_test {
namespace {

constexpr float kDegree = std::numbers::pi_v<float> / 180;

Lens lens(float k1) {
  return make_lens(Vec3f(0.05F, 0.02F, 0.12F), Vec3f(0.03F, 0.04F, 0.09F), Vec3f::UnitY(), 83 * kDegree, k1,
                   240, 180);
}

TEST(Lens, ShowsAPlaceWhereItsRayGoes) {
  for (const float k1 : {-0.09F, -0.06F, 0.0F, 0.1F}) {
    const Lens one = lens(k1);
    for (float y = 5; y < 180; y += 17)
      for (float x = 5; x < 240; x += 23) {
        const Vec3f p = one.position_m + 0.04F * one.ray(x, y);
        const ScreenPoint seen = one.project(p);
        ASSERT_GT(seen.inverse_depth, 0) << k1 << " " << x << " " << y;
        // Rounded to subpixels.
        EXPECT_NEAR(static_cast<float>(seen.x) / kSubpixels, x, 0.05F) << k1;
        EXPECT_NEAR(static_cast<float>(seen.y) / kSubpixels, y, 0.05F) << k1;
        EXPECT_NEAR(1 / seen.inverse_depth, (p - one.position_m).dot(one.forward), 1e-6F);
      }
  }
}

TEST(Lens, SpansItsFieldOfView) {
  const Lens one = lens(0);
  EXPECT_NEAR(std::acos(one.ray(0, 90).dot(one.ray(240, 90))), 83 * kDegree, 1e-3F);
  EXPECT_NEAR(one.ray(120, 90).dot((Vec3f(0.03F, 0.04F, 0.09F) - one.position_m).normalized()), 1, 1e-6F);
  // Up is up, and the performer's left is on the left for who looks at a face.
  EXPECT_GT(one.ray(120, 10).y(), one.ray(120, 170).y());
  EXPECT_GT(one.ray(200, 90).x(), one.ray(40, 90).x());
}

TEST(Lens, ABarrelDrawsTheRimInwards) {
  const Vec3f aside = lens(0).position_m + 0.05F * lens(0).ray(230, 90);
  EXPECT_LT(lens(-0.08F).project(aside).x, lens(0).project(aside).x);
  EXPECT_GT(lens(0.08F).project(aside).x, lens(0).project(aside).x);
}

TEST(Lens, DoesNotShowWhatLiesBehindOrBeyondItsRim) {
  const Lens one = lens(-0.1F);
  EXPECT_EQ(one.project(one.position_m - 0.01F * one.forward).inverse_depth, 0);
  EXPECT_EQ(one.project(one.position_m).inverse_depth, 0);
  // Beyond a tangent of 1 / sqrt(0.3) the picture would fold back.
  EXPECT_GT(one.project(one.position_m + one.forward + 1.8F * one.right).inverse_depth, 0);
  EXPECT_EQ(one.project(one.position_m + one.forward + 1.9F * one.right).inverse_depth, 0);
  const float nan = std::nanf("");
  EXPECT_EQ(one.project(Vec3f(nan, nan, nan)).inverse_depth, 0);
}

TEST(Lens, ManyAtOnceAreTheSameAsOneByOne) {
  const Lens one = lens(-0.06F);
  std::vector<float> x, y, z;
  for (int i = 0; i < 100; ++i) {
    x.push_back(0.05F + 0.002F * static_cast<float>(i % 17) - 0.016F);
    y.push_back(0.02F + 0.003F * static_cast<float>(i % 13) - 0.018F);
    z.push_back(0.05F + 0.001F * static_cast<float>(i));
  }
  std::vector<ScreenPoint> many(x.size());
  one.project(x, y, z, many);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const ScreenPoint alone = one.project(Vec3f(x[i], y[i], z[i]));
    EXPECT_EQ(alone.x, many[i].x);
    EXPECT_EQ(alone.y, many[i].y);
    EXPECT_EQ(alone.inverse_depth, many[i].inverse_depth);
  }
}

}  // namespace
}  // namespace mien::render::lens_test
