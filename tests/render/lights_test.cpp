#include "mien/render/lights.h"

#include <gtest/gtest.h>

#include "mien/render/camera.h"
#include "tests/render/ball_face.h"

namespace mien::render::lights_test {
namespace {

Image drawn(std::string_view light, int side) {
  const face::Face face = ball_face();
  Renderer renderer(face, Quality::video);
  return renderer.still(face.neutral_m, portrait_camera(face, kFrontView_rad, side, side),
                        find_light(light)->look);
}

TEST(Lights, HaveNamesAndLightAFaceEachInItsWay) {
  ASSERT_EQ(named_lights().size(), 4U);
  for (const NamedLight& one : named_lights()) {
    const Image a = drawn(one.name, 32);
    EXPECT_NEAR(one.look.key.direction.norm(), 1, 1e-5);
    for (const NamedLight& other : named_lights())
      if (&other != &one) {
        EXPECT_NE(a, drawn(other.name, 32)) << one.name << " and " << other.name;
      }
  }
  EXPECT_EQ(find_light("moon"), nullptr);
}

TEST(Lights, EveningIsWarmAndInfraredIsGrey) {
  const Image evening = drawn("evening", 32), infrared = drawn("infrared", 32);
  const std::uint8_t* lit = evening.pixel(11, 16);
  EXPECT_GT(lit[0], lit[2] + 20);
  for (std::size_t i = 0; i < infrared.rgb.size(); i += 3) {
    EXPECT_EQ(infrared.rgb[i], infrared.rgb[i + 1]);
    EXPECT_EQ(infrared.rgb[i], infrared.rgb[i + 2]);
  }
  EXPECT_GT(infrared.pixel(16, 16)[0], 60);
}

TEST(Lights, ALonePixelIsAPicture) {
  EXPECT_EQ(drawn("studio", 1).rgb.size(), 3U);
}

}  // namespace
}  // namespace mien::render::lights_test
