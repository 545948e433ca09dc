// Colours at 850 nm.
#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include "mien/builtin_face/albedo.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/person.h"

namespace mien::builtin_face::infrared_test {
namespace {

float mean(const face::Face& face, std::string_view name) {
  float sum = 0, count = 0;
  for (const face::Part& part : face.parts)
    if (part.name == name)
      for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t)
        for (const std::uint32_t i : face.triangles[t]) {
          sum += face.colour[i].x();
          ++count;
        }
  return sum / count;
}

face::Face in_infrared(std::string_view name) {
  const BuiltinParameters who = find_person(name)->parameters;
  face::Face face = make_builtin(who);
  paint_infrared(face, who);
  return face;
}

TEST(Infrared, IsGreyAndBesideEveryVertex) {
  const face::Face face = in_infrared("builtin:hana");
  ASSERT_EQ(face.colour.size(), face.neutral_m.size());
  for (const Vec3f& c : face.colour) {
    EXPECT_EQ(c.x(), c.y());
    EXPECT_EQ(c.x(), c.z());
    EXPECT_GT(c.x(), 0);
    EXPECT_LE(c.x(), 1);  // Of clear tears alone it is 1.
  }
}

TEST(Infrared, SkinIsBrightAndEvenWhateverItsTone) {
  const face::Face fair = in_infrared("builtin:ada,hair=none"), deep = in_infrared("builtin:chidi,hair=none");
  for (const face::Face* face : {&fair, &deep}) {
    EXPECT_GT(mean(*face, "skin"), 0.4F);
    EXPECT_GT(mean(*face, "lips"), 0.8F * mean(*face, "skin")) << "lips are faint";
    EXPECT_LT(mean(*face, "pupil_L"), 0.02F);
    EXPECT_LT(mean(*face, "iris_L"), 0.6F * mean(*face, "sclera_L"));
    EXPECT_LT(mean(*face, "lashes"), 0.3F * mean(*face, "skin"));
  }
  EXPECT_LT(mean(fair, "skin"), 1.6F * mean(deep, "skin"));
  const face::Face seen_fair = make_builtin(find_person("builtin:ada,hair=none")->parameters),
                   seen_deep = make_builtin(find_person("builtin:chidi,hair=none")->parameters);
  EXPECT_GT(mean(seen_fair, "skin"), 4 * mean(seen_deep, "skin")) << "as in visible light it is not";
}

TEST(Infrared, HairGoesByItsPigment) {
  const auto hair = [](double tone, double red, double grey) {
    return infrared_albedos({.hair_tone = tone, .hair_red = red, .hair_grey = grey}).hair.x();
  };
  EXPECT_LT(hair(1, 0, 0), 0.12F);
  EXPECT_GT(hair(0, 0, 0), 0.5F);
  EXPECT_GT(hair(0.3, 1, 0), hair(0.3, 0, 0));
  EXPECT_GT(hair(1, 0, 1), 0.5F);
}

}  // namespace
}  // namespace mien::builtin_face::infrared_test
