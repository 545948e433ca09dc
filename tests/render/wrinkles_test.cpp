// Lines that strain folds the skin into.
#include "mien/render/wrinkles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mien/builtin_face/builtin_face.h"
#include "mien/builtin_face/skin_marks.h"
#include "mien/render/renderer.h"

namespace mien::render::test::wrinkles_test {
namespace {

constexpr face::SkinFolds kYoung = {.depth = 0.5F, .slack = -0.03F};

/// The steepest slope that a pose gives a region.
float steepest(const Wrinkles& wrinkles, Wrinkles::Region region, std::span<const Vec3f> vertices_m) {
  std::vector<Wrinkles::Slopes> slopes(vertices_m.size(), Wrinkles::Slopes::Zero());
  wrinkles.fold(vertices_m, slopes);
  float most = 0;
  for (const Wrinkles::Slopes& s : slopes) most = std::max(most, s[region]);
  return most;
}

std::vector<Vec3f> posed(const face::Face& face, std::initializer_list<std::string_view> shapes) {
  face::BlendshapeWeights weights;
  for (const std::string_view name : shapes) weights[face::shape_index(name)] = 1;
  std::vector<Vec3f> vertices_m(face.neutral_m.size());
  face::evaluate(face, weights, 0, vertices_m);
  return vertices_m;
}

TEST(Wrinkles, StrainIsZeroAtRestAndThatOfAScaling) {
  const face::Face& face = builtin_face::default_builtin();
  const Wrinkles wrinkles(face, kYoung);
  ASSERT_FALSE(wrinkles.empty());
  std::vector<Vec3f> smaller;
  for (const Vec3f& p : face.neutral_m) smaller.emplace_back(0.9F * p);
  for (int r = 0; r < Wrinkles::region_count; ++r) {
    const auto region = static_cast<Wrinkles::Region>(r);
    int rows = 0;
    for (std::uint32_t i = 0; i < face.neutral_m.size(); ++i) {
      const float shrunk = wrinkles.strain(region, i, smaller);
      if (shrunk == 0) continue;
      ++rows;
      EXPECT_NEAR(shrunk, -0.1F, 1e-3F) << r << " at " << i;
      EXPECT_NEAR(wrinkles.strain(region, i, face.neutral_m), 0, 1e-3F) << r << " at " << i;
    }
    EXPECT_GT(rows, 0) << "region " << r;
  }
}

TEST(Wrinkles, ExpressionsFoldWhatTheyShorten) {
  const face::Face& face = builtin_face::default_builtin();
  const Wrinkles wrinkles(face, kYoung);
  const auto brows_up = posed(face, {"browInnerUp_L", "browInnerUp_R", "browOuterUp_L", "browOuterUp_R"});
  const auto frown = posed(face, {"browDown_L", "browDown_R"});
  for (const Wrinkles::Region region : {Wrinkles::forehead, Wrinkles::frown, Wrinkles::nasolabial})
    EXPECT_EQ(steepest(wrinkles, region, face.neutral_m), 0) << "young skin is smooth at rest";
  EXPECT_GT(steepest(wrinkles, Wrinkles::forehead, brows_up), 0.1F);
  EXPECT_EQ(steepest(wrinkles, Wrinkles::forehead, frown), 0);
  EXPECT_GT(steepest(wrinkles, Wrinkles::frown, frown), 0.1F);
}

TEST(Wrinkles, StayAtRestWithAge) {
  builtin_face::BuiltinParameters old;
  old.age_years = 75;
  const face::Face face = builtin_face::make_builtin(old);
  const Wrinkles wrinkles(face, builtin_face::skin_folds(old));
  EXPECT_GT(steepest(wrinkles, Wrinkles::forehead, face.neutral_m), 0.1F);
  EXPECT_GT(steepest(wrinkles, Wrinkles::crows_feet, face.neutral_m), 0.1F);
}

TEST(Wrinkles, NobodyHasAnyUnlessTold) {
  EXPECT_TRUE(Wrinkles(builtin_face::default_builtin(), {}).empty());
  face::Face unmarked = builtin_face::default_builtin();
  unmarked.has_landmarks = false;
  EXPECT_TRUE(Wrinkles(unmarked, kYoung).empty());
}

TEST(Wrinkles, AFilmShowsWhatAFreshRendererShows) {
  const face::Face& face = builtin_face::default_builtin();
  const Camera camera = portrait_camera(face, kFrontView_rad, 96, 96);
  const face::SkinFolds old = {.depth = 0.8F, .slack = 0.05F};
  Renderer film(face, Quality::video, 2, old);
  const auto brows_up = posed(face, {"browInnerUp_L", "browInnerUp_R", "browOuterUp_L", "browOuterUp_R"});
  for (const auto* pose : {&face.neutral_m, &brows_up, &face.neutral_m})
    EXPECT_EQ(film.still(*pose, camera, Look::dark()),
              Renderer(face, Quality::video, 1, old).still(*pose, camera, Look::dark()));
  EXPECT_NE(Renderer(face, Quality::video, 2).still(brows_up, camera, Look::dark()),
            Renderer(face, Quality::video, 2, old).still(brows_up, camera, Look::dark()));
}

}  // namespace
}  // namespace mien::render::test::wrinkles_test
