#include "mien/builtin_face/haircut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/surface.h"

namespace mien::builtin_face::haircut_test {
namespace {

constexpr HairStyle kStyles[] = {HairStyle::crop, HairStyle::swept, HairStyle::bob, HairStyle::curls,
                                 HairStyle::tied};

const face::Part* part(const face::Face& face, std::string_view name) {
  const auto found = std::ranges::find(face.parts, name, &face::Part::name);
  return found == face.parts.end() ? nullptr : &*found;
}

TEST(Haircut, EveryStyleIsRibbonsOfStrandsAndLikeNoOther) {
  std::set<std::size_t> sizes;
  for (const HairStyle style : kStyles) {
    const Haircut& cut = haircut(style);
    ASSERT_EQ(cut.uv.size(), cut.p.size());
    ASSERT_EQ(cut.shade.size(), cut.p.size());
    EXPECT_GT(cut.triangles.size(), 5000U);
    EXPECT_LT(cut.p.size(), 32000U) << "a page loads and draws it";
    for (std::size_t i = 0; i < cut.p.size(); ++i) {
      ASSERT_TRUE(cut.p[i].allFinite());
      ASSERT_TRUE(cut.uv[i].y() >= 0 && cut.uv[i].y() <= 1);
      ASSERT_TRUE(cut.shade[i] > 0 && cut.shade[i] < 2);
    }
    for (const auto& t : cut.triangles) ASSERT_LT(std::ranges::max(t), cut.p.size());
    sizes.insert(cut.p.size());
  }
  EXPECT_EQ(sizes.size(), std::size(kStyles));
}

TEST(Haircut, GrowsOnTheScalpAndStaysOutOfTheHead) {
  for (const HairStyle style : kStyles) {
    const Haircut& cut = haircut(style);
    std::size_t inside = 0, roots = 0;
    for (std::size_t i = 0; i < cut.p.size(); ++i) {
      if (head_distance(cut.p[i]) < -2.5) ++inside;
      if (cut.uv[i].y() > 0) continue;
      ++roots;
      if (style != HairStyle::tied) {
        EXPECT_GT(within_hairline(cut.p[i]), -9.5) << "style " << static_cast<int>(style);
      }
    }
    EXPECT_GT(roots, 1000U);
    EXPECT_LT(static_cast<double>(inside), 0.01 * static_cast<double>(cut.p.size()))
        << "style " << static_cast<int>(style);
  }
}

TEST(Haircut, LeavesTheFaceFree) {
  for (const HairStyle style : kStyles)
    for (const Vec3& p : haircut(style).p)
      EXPECT_FALSE(std::abs(p.x()) < 48 && p.y() > -60 && p.y() < 48 && p.z() > 75)
          << p.transpose() << " of style " << static_cast<int>(style);
}

TEST(Haircut, TheHairlineIsWhereHairBegins) {
  EXPECT_GT(within_hairline({0, 130, 30}), 20) << "crown";
  EXPECT_LT(within_hairline({0, 60, 98}), -20) << "forehead";
  EXPECT_LT(within_hairline({50, -20, 80}), -20) << "cheek";
  EXPECT_GT(within_hairline({30, 40, -85}), 20) << "back of the head";
  EXPECT_EQ(within_hairline({30, 90, 60}), within_hairline({-30, 90, 60}));
}

TEST(Haircut, EverythingElseKeepsItsPlaceWhateverTheStyle) {
  const face::Face bald = make_builtin();
  EXPECT_EQ(part(bald, "hair"), nullptr);
  for (const HairStyle style : kStyles) {
    const face::Face face = make_builtin({.hair = style});
    const face::Part* hair = part(face, "hair");
    ASSERT_NE(hair, nullptr);
    EXPECT_EQ(hair->material, face::Material::strands);
    EXPECT_EQ(hair->first_triangle + hair->triangle_count, face.triangles.size());
    ASSERT_GT(face.neutral_m.size(), bald.neutral_m.size());
    EXPECT_TRUE(std::equal(bald.neutral_m.begin(), bald.neutral_m.end(), face.neutral_m.begin()));
    EXPECT_EQ(face.uv.size(), face.neutral_m.size());
    EXPECT_EQ(face.colour.size(), face.neutral_m.size());
    for (std::size_t k = 0; k < face.shapes.size(); ++k)
      EXPECT_EQ(face.shapes[k].vertex, bald.shapes[k].vertex) << "hair stays where it is";
  }
}

TEST(Haircut, AStyleComesFromAStreamOfItsOwn) {
  std::set<HairStyle> seen;
  int bald = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random(seed);
    const BuiltinParameters person = random_identity(random);
    seen.insert(person.hair);
    bald += person.hair == HairStyle::none ? 1 : 0;
    EXPECT_EQ(without_hair(person).hair, HairStyle::none);
    EXPECT_EQ(without_hair(person).head_width, person.head_width);
  }
  EXPECT_EQ(seen.size(), kHairStyleCount);
  EXPECT_NEAR(bald, 30, 18);
}

}  // namespace
}  // namespace mien::builtin_face::haircut_test
