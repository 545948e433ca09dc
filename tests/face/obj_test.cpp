#include "mien/face/obj.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace mien::face::obj_test {
namespace {

TEST(Obj, ReadsPolygonsOfEveryNotationAsFans) {
  const auto mesh = parse_obj(
      "# a comment\r\nmtllib x.mtl\nv 0 0 0\r\nv 1 0 0 0.5 0.5 0.5\nv\t1 1 0\nv 0 +1 0\nv -1 5e-1 1e-60\n"
      "vt 0 0\nusemtl M Face\nf 1/1 2/2 3/3 4/4\nf 1//1 3//2 4//3\nusemtl Other\nf -5/1/1 -4/2/2 -3/3/3 -2 "
      "-1",
      "test");
  ASSERT_TRUE(mesh) << mesh.error().message();
  EXPECT_EQ(mesh->position.size(), 5U);
  EXPECT_EQ(mesh->position[4], Vec3f(-1, 0.5F, 0));
  const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 3}, {0, 2, 3},
                                                               {0, 1, 2}, {0, 2, 3}, {0, 3, 4}};
  EXPECT_EQ(mesh->triangles, triangles);
  ASSERT_EQ(mesh->groups.size(), 2U);
  EXPECT_EQ(mesh->groups[0].material, "M Face");
  EXPECT_EQ(mesh->groups[0].triangle_count, 3U);
  EXPECT_EQ(mesh->groups[1].first_triangle, 3U);
  EXPECT_EQ(mesh->groups[1].triangle_count, 3U);
}

TEST(Obj, ReadsPositionsAloneWithoutLookingAtFaces) {
  const auto mesh = parse_obj("v 1 2 3\nf 9 9 nonsense\n", "test", ObjContent::positions);
  ASSERT_TRUE(mesh);
  EXPECT_EQ(mesh->position.size(), 1U);
  EXPECT_TRUE(mesh->triangles.empty());
}

struct BadObj {
  const char* what;
  const char* text;
  ErrorCode code;
};

class ObjRefuses : public ::testing::TestWithParam<BadObj> {};

TEST_P(ObjRefuses, WithOneLineThatNamesThePlace) {
  const auto mesh = parse_obj(GetParam().text, "bad.obj");
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().code, GetParam().code);
  EXPECT_EQ(mesh.error().where.rfind("bad.obj", 0), 0U);
  EXPECT_EQ(mesh.error().message().find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Obj, ObjRefuses,
    ::testing::Values(BadObj{"empty", "", ErrorCode::truncated},
                      BadObj{"no vertex", "# nothing\nvn 0 0 1\n", ErrorCode::truncated},
                      BadObj{"two numbers", "v 1 2\n", ErrorCode::malformed},
                      BadObj{"cut in a number", "v 1 2 -", ErrorCode::malformed},
                      BadObj{"not a number", "v 1 2 x\n", ErrorCode::malformed},
                      BadObj{"nan", "v nan 0 0\n", ErrorCode::malformed},
                      BadObj{"infinity", "v 0 -inf 0\n", ErrorCode::malformed},
                      BadObj{"beyond a double", "v 0 0 1e999\n", ErrorCode::malformed},
                      BadObj{"beyond reason", "v 0 0 1e30\n", ErrorCode::malformed},
                      BadObj{"glued", "v 1.0.0 0 0\n", ErrorCode::malformed},
                      BadObj{"face of two", "v 0 0 0\nf 1 1\n", ErrorCode::malformed},
                      BadObj{"index 0", "v 0 0 0\nf 1 1 0\n", ErrorCode::out_of_range},
                      BadObj{"index beyond", "v 0 0 0\nf 1 1 2\n", ErrorCode::out_of_range},
                      BadObj{"index before", "v 0 0 0\nf 1 1 -2\n", ErrorCode::out_of_range},
                      BadObj{"huge index", "v 0 0 0\nf 1 1 99999999999999999999\n", ErrorCode::out_of_range},
                      BadObj{"large index", "v 0 0 0\nf 1 1 4294967297\n", ErrorCode::out_of_range}),
    [](const auto& one) {
      std::string name = one.param.what;
      std::ranges::replace(name, ' ', '_');
      return name;
    });

TEST(Obj, WhatIsWrittenReadsBackTheSame) {
  Face face;
  face.name = "two triangles";
  face.neutral_m = {{0, 0, 0}, {0.1F, 0, 0}, {0.1F, 1.0F / 3, 0}, {0, 0.1F, -7e-5F}};
  face.triangles = {{0, 1, 2}, {0, 2, 3}};
  face.parts = {{"skin", Material::skin, 0, 1}, {"lips", Material::lips, 1, 1}};
  const auto mesh = parse_obj(format_obj(face, face.neutral_m), "written");
  ASSERT_TRUE(mesh) << mesh.error().message();
  EXPECT_EQ(mesh->position, face.neutral_m);
  EXPECT_EQ(mesh->triangles, face.triangles);
  ASSERT_EQ(mesh->groups.size(), 2U);
  EXPECT_EQ(mesh->groups[1].material, "lips");
}

}  // namespace
}  // namespace mien::face::obj_test
