#include "mien/render/renderer.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <vector>

#include "mien/render/comparison.h"
#include "mien/render/error_colours.h"
#include "tests/render/ball_face.h"

namespace mien::render::renderer_test {
namespace {

std::vector<Vec3f> posed(const face::Face& face, std::size_t shape, float weight) {
  face::BlendshapeWeights w;
  w[shape] = weight;
  std::vector<Vec3f> vertices_m(face.neutral_m.size());
  face::evaluate(face, w, 0, vertices_m);
  face::turn_eyes(face, w, vertices_m);
  return vertices_m;
}

Camera camera_of(const face::Face& face, int side = 96) {
  return portrait_camera(face, kFrontView_rad, side, side);
}

/// Mean of the red bytes in columns [from, until).
double brightness(const Image& picture, int from, int until) {
  double sum = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = from; x < until; ++x) sum += picture.pixel(x, y)[0];
  return sum / (static_cast<double>(until - from) * picture.height);
}

TEST(Renderer, DoesNotDependOnTheNumberOfThreads) {
  const face::Face face = ball_face();
  const auto pose = posed(face, face::shape("jawOpen"), 1);
  Renderer one(face, Quality::still, 1), three(face, Quality::still, 3);
  EXPECT_EQ(one.still(pose, camera_of(face), Look::dark()), three.still(pose, camera_of(face), Look::dark()));
}

TEST(Renderer, RefittingGivesWhatBuildingAfreshGives) {
  const face::Face face = ball_face();
  const auto smile = posed(face, face::shape("mouthSmile_L"), 1);
  Renderer used(face, Quality::video, 2), fresh(face, Quality::video, 2);
  for (int i = 0; i < 5; ++i)
    (void)used.still(posed(face, face::shape("jawOpen"), 0.2F * static_cast<float>(i)), camera_of(face),
                     Look::dark());
  EXPECT_EQ(used.still(smile, camera_of(face), Look::dark()),
            fresh.still(smile, camera_of(face), Look::dark()));
}

TEST(Renderer, ShowsTheFaceInTheMiddleAndTheBackgroundAround) {
  const face::Face face = ball_face();
  Renderer renderer(face, Quality::video, 2);
  const Image picture = renderer.still(face.neutral_m, camera_of(face), Look::light());
  // The upper corner is the backdrop, in the middle is skin: red before blue.
  EXPECT_NEAR(picture.pixel(1, 1)[0], picture.pixel(1, 1)[2], 12);
  EXPECT_GT(picture.pixel(1, 1)[0], 150);
  EXPECT_GT(picture.pixel(48, 40)[0], picture.pixel(48, 40)[2] + 20);
}

TEST(Renderer, LightComesFromWhereItStands) {
  const face::Face face = ball_face();
  Renderer renderer(face, Quality::video, 2);
  Look look;
  look.key = {Vec3f(-1, 0, 0.3F).normalized(), Vec3f::Constant(2), 0.2F};
  const Image picture = renderer.still(face.neutral_m, camera_of(face), look);
  EXPECT_GT(brightness(picture, 0, 48), 2 * brightness(picture, 48, 96));
  EXPECT_EQ(brightness(renderer.still(face.neutral_m, camera_of(face), Look()), 0, 96), 0)
      << "without light, black";
}

TEST(Renderer, EyesCatchTheLightAndFollow) {
  const face::Face face = ball_face();
  Camera camera = camera_of(face, 160);
  camera.target_m = face.eyes[0].centre_m;
  camera.field_of_view_rad *= 0.3F;
  Renderer renderer(face, Quality::video, 2);
  const Image ahead = renderer.still(face.neutral_m, camera, Look::dark());
  const Image aside = renderer.still(posed(face, face::shape("eyeLookOut_L"), 1), camera, Look::dark());
  // The dark pupil moves to the performer's left, which is the picture's right.
  const auto darkest_column = [](const Image& picture) {
    int best = 0, value = 255 * 4;
    for (int x = 20; x < picture.width - 20; ++x) {
      int sum = 0;
      for (int dx = -1; dx <= 2; ++dx) sum += picture.pixel(x + dx, picture.height / 2 + 4)[0];
      if (sum < value) {
        value = sum;
        best = x;
      }
    }
    return best;
  };
  EXPECT_GT(darkest_column(aside), darkest_column(ahead) + 8);
}

TEST(Renderer, ErrorColoursPaintTheFaceAndLeaveTheBackground) {
  const face::Face face = ball_face();
  Renderer renderer(face, Quality::video, 2);
  const std::vector<float> none(face.neutral_m.size(), 0.0F), large(face.neutral_m.size(), 1.0F);
  const ErrorColours clean{none, 5e-3F}, wrong{large, 5e-3F};
  const Image pale = renderer.still(face.neutral_m, camera_of(face), Look::dark(), &clean);
  const Image dark = renderer.still(face.neutral_m, camera_of(face), Look::dark(), &wrong);
  EXPECT_GT(pale.pixel(48, 40)[1], 2 * dark.pixel(48, 40)[1]);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(pale.pixel(1, 1)[c], dark.pixel(1, 1)[c]);
}

/// A ribbon of dark hair before the middle of the ball, two centimetres across.
face::Face face_with_a_ribbon(float hairs) {
  face::Face face = ball_face();
  face.uv.assign(face.neutral_m.size(), Eigen::Vector2f::Zero());
  face.colour.assign(face.neutral_m.size(), Vec3f(0.6F, 0.4F, 0.3F));
  const auto first = static_cast<std::uint32_t>(face.neutral_m.size());
  for (int k = 0; k < 4; ++k) {
    face.neutral_m.emplace_back(k % 2 == 0 ? -0.01F : 0.01F, k < 2 ? 0.01F : -0.03F, 0.12F);
    face.uv.emplace_back(k % 2 == 0 ? 0.0F : hairs / face::kStrandsPerUv, k < 2 ? 0.0F : 1.0F);
    face.colour.emplace_back(0.01F, 0.01F, 0.01F);
  }
  face.parts.push_back(
      {"hair", face::Material::strands, static_cast<std::uint32_t>(face.triangles.size()), 2});
  face.triangles.push_back({first, first + 1, first + 3});
  face.triangles.push_back({first, first + 3, first + 2});
  return face;
}

TEST(Renderer, HairCoversWhereItsHairsAreAndSkinIsSeenBetweenThem) {
  const face::Face bald = ball_face(), haired = face_with_a_ribbon(4);
  const Camera camera = camera_of(bald, 128);
  const Image without = Renderer(bald, Quality::still, 2).still(bald.neutral_m, camera, Look::light());
  const Image with = Renderer(haired, Quality::still, 2).still(haired.neutral_m, camera, Look::light());
  // Along a line across the ribbon's middle, dark hairs and lit skin take turns.
  const int middle = 64, row = 64 + 6;
  int dark = 0, lit = 0;
  for (int x = middle - 8; x < middle + 8; ++x) {
    const int drop = without.pixel(x, row)[0] - with.pixel(x, row)[0];
    dark += drop > 60 ? 1 : 0;
    lit += drop < 45 ? 1 : 0;
  }
  EXPECT_GE(dark, 3);
  EXPECT_GE(lit, 2);
  EXPECT_EQ(with.pixel(2, 2)[0], without.pixel(2, 2)[0]) << "nothing but the ribbon changed";
}

TEST(Renderer, AFilmShowsEachPoseAsAFirstPicture) {
  // What rests is lit and drawn once: whichever came before, and whether hair rests or turns with the head.
  const face::Face face = face_with_a_ribbon(4);
  const Camera camera = camera_of(ball_face(), 128);
  std::vector<std::vector<Vec3f>> poses = {face.neutral_m, posed(face, face::shape("jawOpen"), 1),
                                           posed(face, face::shape("mouthSmile_L"), 0.5F), face.neutral_m};
  for (Vec3f& p : poses[3]) p = Eigen::AngleAxisf(0.3F, Vec3f::UnitY()) * p;
  Renderer film(face, Quality::video, 2);
  for (const std::size_t k : {1U, 0U, 2U, 3U, 1U, 0U, 3U, 2U}) {
    const Image shown = film.still(poses[k], camera, Look::dark());
    EXPECT_EQ(shown, Renderer(face, Quality::video, 2).still(poses[k], camera, Look::dark())) << k;
  }
  // Another camera or look begins anew.
  EXPECT_EQ(film.still(poses[1], camera, Look::light()),
            Renderer(face, Quality::video, 2).still(poses[1], camera, Look::light()));
}

TEST(Renderer, TwoPicturesAtOnceAreThoseDrawnAlone) {
  const face::Face face = face_with_a_ribbon(4);
  const auto pose = posed(face, face::shape("jawOpen"), 1);
  std::vector<float> error_m(face.neutral_m.size());
  for (std::size_t i = 0; i < error_m.size(); ++i) error_m[i] = (pose[i] - face.neutral_m[i]).norm();
  const ErrorColours errors{error_m, 5e-3F};
  for (const Quality quality : {Quality::still, Quality::video}) {
    Renderer renderer(face, quality, 2);
    renderer.light(pose, camera_of(ball_face(), 96), Look::dark());
    const Renderer::Pictures both = renderer.draw_with_errors(errors);
    EXPECT_EQ(both.plain, renderer.draw());
    EXPECT_EQ(both.errors, renderer.draw(&errors));
    EXPECT_NE(both.plain, both.errors);
  }
}

TEST(Renderer, StrandsWithoutTextureCoordinatesAreDrawnAsOnePiece) {
  face::Face face = face_with_a_ribbon(4);
  face.uv.clear();
  const Image picture =
      Renderer(face, Quality::still, 2).still(face.neutral_m, camera_of(ball_face(), 128), Look::light());
  for (int x = 60; x < 68; ++x) EXPECT_LT(picture.pixel(x, 70)[0], 90) << x;
}

TEST(Renderer, TakesFacesWithoutPartsColoursOrLandmarks) {
  face::Face face;
  add_ball(face, "all", face::Material::skin, Vec3f::Zero(), 0.1F, 6);
  face.parts.clear();
  Renderer renderer(face, Quality::video, 2);
  EXPECT_GT(brightness(renderer.still(face.neutral_m, camera_of(face, 32), Look::dark()), 8, 24), 20);
}

TEST(Comparison, IsThreeViewsAndSaysZeroWhereThereIsNoError) {
  const Lettering lettering = Lettering::load().value();
  const face::Face face = ball_face();
  Renderer renderer(face, Quality::video, 2);
  const Camera camera = camera_of(face, 160);
  const Image same =
      comparison(renderer, lettering, face.neutral_m, face.neutral_m, camera, Look::dark(), {});
  ASSERT_EQ(same.width, 480);
  ASSERT_EQ(same.height, 160);
  const Image wrong = comparison(renderer, lettering, posed(face, face::shape("jawOpen"), 1), face.neutral_m,
                                 camera, Look::dark(), {});
  // The lower half moved by up to 20 mm, the upper not at all.
  EXPECT_GT(same.pixel(400, 115)[1], 1.5 * wrong.pixel(400, 115)[1]);
  EXPECT_EQ(same.pixel(400, 50)[1], wrong.pixel(400, 50)[1]);
}

TEST(Camera, HoldsTheFaceFromEverySide) {
  const face::Face face = ball_face();
  for (const char* name : {"front", "three-quarter", "side"}) {
    const auto view = view_rad_from_name(name);
    ASSERT_TRUE(view.has_value());
    const Camera camera = portrait_camera(face, *view, 64, 64);
    const float half = std::tan(0.5F * camera.field_of_view_rad);
    const Vec3f forward = (camera.target_m - camera.position_m).normalized();
    for (const Vec3f& p : face.neutral_m) {
      const Vec3f d = p - camera.position_m;
      const float depth = d.dot(forward);
      EXPECT_LT((d - depth * forward).norm(), 1.42F * half * depth);
    }
  }
  EXPECT_NEAR(view_rad_from_name("-90").value(), -1.5708F, 1e-4F);
  for (const char* wrong : {"behind", "", "45 ", "361", "nan", "inf"})
    EXPECT_FALSE(view_rad_from_name(wrong).has_value()) << wrong;
}

}  // namespace
}  // namespace mien::render::renderer_test
