#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/surface.h"

namespace mien::builtin_face::shirt_test {
namespace {

std::set<std::uint32_t> shirt_of(const face::Face& face) {
  const auto part = std::ranges::find(face.parts, "shirt", &face::Part::name);
  std::set<std::uint32_t> vertices;
  for (std::uint32_t t = part->first_triangle; t < part->first_triangle + part->triangle_count; ++t)
    vertices.insert(face.triangles[t].begin(), face.triangles[t].end());
  return vertices;
}

TEST(Shirt, ClosesAboutTheNeckBelowTheChinAndStaysStill) {
  for (const double neck : {-3.0, 0.0, 3.0}) {
    const face::Face face = make_builtin({.neck_width = neck});
    const std::set<std::uint32_t> shirt = shirt_of(face);
    ASSERT_GT(shirt.size(), 500U);
    float highest = -1, widest = 0;
    for (const std::uint32_t i : shirt) {
      highest = std::max(highest, face.neutral_m[i].y());
      widest = std::max(widest, face.neutral_m[i].x());
    }
    const float chin = face.neutral_m[face.landmarks[8]].y();
    EXPECT_LT(highest, chin - 0.03F);
    EXPECT_GT(widest, 0.14F) << "it has shoulders";
    for (const face::Shape& shape : face.shapes)
      for (const std::uint32_t i : shape.vertex) ASSERT_FALSE(shirt.contains(i)) << shape.name;
  }
}

TEST(Shirt, NoSkinComesThroughTheCloth) {
  const face::Face face = make_builtin();
  std::size_t under = 0;
  const std::set<std::uint32_t> shirt = shirt_of(face);
  for (const std::uint32_t i : shirt)
    if (head_distance(1000 * face.neutral_m[i].cast<double>()) < 1) ++under;
  // The collar's inner edge alone is tucked in: one ring of fifteen.
  EXPECT_LE(under, shirt.size() / 15 + 2);
}

}  // namespace
}  // namespace mien::builtin_face::shirt_test
