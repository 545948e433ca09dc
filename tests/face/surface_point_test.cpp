#include "mien/face/surface_point.h"

#include <gtest/gtest.h>

#include "mien/builtin_face/builtin_face.h"

namespace mien::face::surface_point_test {
namespace {

/// Two triangles of a square in z = 0, of which one corner can be lifted.
Face square() {
  Face face;
  face.neutral_m = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(1, 1, 0), Vec3f(0, 1, 0)};
  face.triangles = {{0, 1, 2}, {0, 2, 3}};
  face.shapes.push_back({"lift", {2}, {Vec3f(0, 0, 0.5F)}});
  return face;
}

TEST(SurfacePoint, IsTheNearestOfTheSurface) {
  const Face face = square();
  const std::vector<std::uint32_t> triangles = skin_triangles(face);
  ASSERT_EQ(triangles.size(), 2u);
  for (const auto& [from, to] :
       {std::pair{Vec3(0.3, 0.2, 0.7), Vec3(0.3, 0.2, 0)}, std::pair{Vec3(0.2, 0.6, -1), Vec3(0.2, 0.6, 0)},
        std::pair{Vec3(2, 2, 1), Vec3(1, 1, 0)}, std::pair{Vec3(0.5, -3, 0), Vec3(0.5, 0, 0)}}) {
    const SurfacePoint point = nearest_on_skin(face, triangles, from);
    EXPECT_LT((neutral_position(face, point) - to).norm(), 1e-9);
    EXPECT_NEAR(point.weight[0] + point.weight[1] + point.weight[2], 1, 1e-12);
  }
}

TEST(SurfacePoint, GoesWithItsTriangle) {
  const Face face = square();
  const SurfacePoint middle = nearest_on_skin(face, skin_triangles(face), Vec3(0.5, 0.5, 1));
  EXPECT_NEAR(displacement(face.shapes[0], middle).z(), 0.25, 1e-6);
  const SurfacePoint corner = nearest_on_skin(face, skin_triangles(face), Vec3(0, 0, 1));
  EXPECT_EQ(displacement(face.shapes[0], corner), Vec3::Zero());
}

TEST(SurfacePoint, LandmarksAlignAFaceWithItself) {
  const Face face = builtin_face::make_builtin();
  EXPECT_LT((align_landmarks(face, face).matrix() - Eigen::Matrix4d::Identity()).norm(), 1e-9);
}

}  // namespace
}  // namespace mien::face::surface_point_test
