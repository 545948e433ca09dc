#include "mien/face/face.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mien::face::face_test {
namespace {

/// A square in the XY plane; jawOpen moves one corner, tongueOut another; the last two vertices are eyeballs.
Face small_face() {
  Face face;
  face.neutral_m = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.03F, 0, 0.012F}, {-0.03F, 0, 0.012F}};
  face.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (const std::string_view name : kShapeNames) face.shapes.push_back({std::string(name), {}, {}});
  face.shapes[shape("jawOpen")].vertex = {1, 2};
  face.shapes[shape("jawOpen")].delta_m = {{0, -0.5F, 0}, {0, 0, 0.3F}};
  face.shapes.push_back({"tongueOut", {3}, {{0, 0, 1}}});
  face.eyes = {Eyeball{4, 1, {0.03F, 0, 0}}, Eyeball{5, 1, {-0.03F, 0, 0}}};
  face.regions = {{"skin", {0, 1, 2, 3}}};
  return face;
}

TEST(Face, IsItsNeutralPlusItsWeightedShapes) {
  const Face face = small_face();
  std::vector<Vec3f> vertices(face.neutral_m.size());
  evaluate(face, {}, 0, vertices);
  EXPECT_EQ(vertices, face.neutral_m);
  BlendshapeWeights weights;
  weights[shape("jawOpen")] = 0.5F;
  weights[shape("jawLeft")] = 1;  // Moves nothing here.
  evaluate(face, weights, 0.25F, vertices);
  EXPECT_EQ(vertices[0], face.neutral_m[0]);
  EXPECT_EQ(vertices[1], Vec3f(1, -0.25F, 0));
  EXPECT_EQ(vertices[2], Vec3f(1, 1, 0.15F));
  EXPECT_EQ(vertices[3], Vec3f(0, 1, 0.25F));
}

TEST(Face, PeakIsTheLargestMoveAndZeroWithoutTheShape) {
  const Face face = small_face();
  EXPECT_FLOAT_EQ(peak_displacement_m(face, "jawOpen"), 0.5F);
  EXPECT_EQ(peak_displacement_m(face, "jawLeft"), 0);
  EXPECT_EQ(peak_displacement_m(face, "no such shape"), 0);
}

TEST(Face, EyesTurnToWhereTheWeightsLook) {
  const Face face = small_face();
  const auto looking = [&](std::size_t a, std::size_t b) {
    BlendshapeWeights weights;
    weights[a] = 1;
    weights[b] = 1;
    std::vector<Vec3f> vertices = face.neutral_m;
    turn_eyes(face, weights, vertices);
    return std::array<Vec3f, 2>{vertices[4] - face.eyes[0].centre_m, vertices[5] - face.eyes[1].centre_m};
  };
  const float sideways = 0.012F * std::sin(0.611F);
  for (const Vec3f& front : looking(shape("eyeLookOut_L"), shape("eyeLookIn_R")))
    EXPECT_NEAR(front.x(), sideways, 1e-6);
  for (const Vec3f& front : looking(shape("eyeLookIn_L"), shape("eyeLookOut_R")))
    EXPECT_NEAR(front.x(), -sideways, 1e-6);
  for (const Vec3f& front : looking(shape("eyeLookUp_L"), shape("eyeLookUp_R")))
    EXPECT_NEAR(front.y(), sideways, 1e-6);
  for (const Vec3f& front : looking(shape("eyeLookDown_L"), shape("eyeLookDown_R"))) {
    EXPECT_NEAR(front.y(), -sideways, 1e-6);
    EXPECT_NEAR(front.norm(), 0.012, 1e-6);
  }
}

TEST(Face, NormalsAreUnitAndFaceTheViewerOfACounterClockwiseTriangle) {
  const Face face = small_face();
  std::vector<Vec3f> normals(face.neutral_m.size());
  vertex_normals(face, face.neutral_m, normals);
  for (const Vec3f& n : normals) EXPECT_EQ(n, Vec3f::UnitZ());  // Loose vertices get a direction too.
}

TEST(Face, PartsOfItAreFoundByName) {
  const Face face = small_face();
  ASSERT_NE(face.region("skin"), nullptr);
  EXPECT_EQ(face.region("nose"), nullptr);
  ASSERT_NE(face.find_shape("tongueOut"), nullptr);
  EXPECT_EQ(face.find_shape("tongueIn"), nullptr);
}

}  // namespace
}  // namespace mien::face::face_test
