#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "mien/builtin_face/builtin_face.h"

namespace mien::builtin_face::brows_and_lashes_test {
namespace {

const face::Part* part(const face::Face& face, std::string_view name) {
  const auto found = std::ranges::find(face.parts, name, &face::Part::name);
  return found == face.parts.end() ? nullptr : &*found;
}

TEST(Lashes, GoWithTheirLidAndBrowsWithTheirSkin) {
  const face::Face face = make_builtin();
  const auto moves = [&](std::string_view shape, std::string_view of, bool left) {
    const face::Shape& s = *face.find_shape(shape);
    const face::Part* p = part(face, of);
    std::set<std::uint32_t> own;
    for (std::uint32_t t = p->first_triangle; t < p->first_triangle + p->triangle_count; ++t)
      for (const std::uint32_t i : face.triangles[t])
        if ((face.neutral_m[i].x() > 0) == left) own.insert(i);
    float furthest_m = 0;
    for (std::size_t k = 0; k < s.vertex.size(); ++k)
      if (own.contains(s.vertex[k])) furthest_m = std::max(furthest_m, s.delta_m[k].norm());
    return furthest_m;
  };
  EXPECT_GT(moves("eyeBlink_L", "lashes", true), 0.006F);
  EXPECT_EQ(moves("eyeBlink_L", "lashes", false), 0);
  EXPECT_GT(moves("browOuterUp_R", "brows", false), 0.005F);
  EXPECT_LT(moves("browOuterUp_R", "brows", true), 0.0005F);
}

}  // namespace
}  // namespace mien::builtin_face::brows_and_lashes_test
