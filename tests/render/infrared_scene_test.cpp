#include "mien/render/infrared_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <thread>
#include <vector>

#include "mien/builtin_face/builtin_face.h"

namespace mien::render::infrared_scene_test {
namespace {

constexpr int kSide = 96;

/// The default head, two eye cameras and two mouth cameras that mirror each other, and lamps beside them.
struct Setting {
  face::Face face;
  std::vector<Vec3f> cameras_m;
  std::vector<Lens> lenses;
  std::vector<InfraredLamp> lamps;

  Setting() : face(builtin_face::make_builtin({})) {
    builtin_face::paint_infrared(face, {});
    for (const bool mouth : {false, true})
      for (const float side : {1.0F, -1.0F}) {
        const Vec3f at = mouth ? Vec3f(side * 0.024F, 0.006F, 0.150F) : Vec3f(side * 0.05F, 0.02F, 0.1245F);
        const Vec3f to = mouth ? Vec3f(side * 0.003F, -0.04F, 0.106F) : Vec3f(side * 0.031F, 0.042F, 0.093F);
        cameras_m.push_back(at);
        lenses.push_back(make_lens(at, to, Vec3f::UnitY(), 1.4F, -0.06F, kSide, kSide));
        for (const float up : {-0.008F, 0.008F})
          lamps.push_back({.position_m = at + Vec3f(side * 0.004F, up, 0),
                           .aim = (to - at).normalized(),
                           .intensity = 2e-3F});
      }
  }
  [[nodiscard]] InfraredScene scene(InfraredWearer wearer = {}) const {
    InfraredScene made(face, std::move(wearer), cameras_m);
    made.pose(face.neutral_m, face.neutral_m, {});
    made.light(lamps, 0.1F, lenses);
    return made;
  }
  [[nodiscard]] std::vector<Vec3f> posed(std::initializer_list<std::size_t> shapes, float weight) const {
    face::BlendshapeWeights weights{};
    for (const std::size_t shape : shapes) weights[shape] = weight;
    std::vector<Vec3f> vertices_m(face.neutral_m.size());
    face::evaluate(face, weights, 0, vertices_m);
    face::turn_eyes(face, weights, vertices_m);
    return vertices_m;
  }
};

const Setting& setting() {
  static const Setting once;
  return once;
}

using Picture = std::vector<float>;

Picture draw(const InfraredScene& scene, std::size_t camera, float exposure = 0) {
  Picture picture(std::size_t{kSide} * kSide);
  InfraredScene::Canvas canvas;
  scene.draw(setting().lenses[camera], exposure, canvas, picture);
  return picture;
}

double mean(const Picture& picture) {
  return std::accumulate(picture.begin(), picture.end(), 0.0) / static_cast<double>(picture.size());
}

double difference(const Picture& a, const Picture& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size()) / std::max(1e-12, 0.5 * (mean(a) + mean(b)));
}

TEST(InfraredScene, ShowsWhatRaysOneByOneShow) {
  const InfraredScene scene = setting().scene({.lash_cover = 0});
  for (std::size_t camera = 0; camera < 4; ++camera) {
    Picture by_rays(std::size_t{kSide} * kSide);
    scene.draw_by_rays(setting().lenses[camera], by_rays);
    const Picture drawn = draw(scene, camera);
    ASSERT_GT(mean(by_rays), 0);
    // Straight edges of triangles stand for what the lens bends, and a pixel is shaded once a triangle.
    EXPECT_LT(difference(drawn, by_rays), 0.03) << camera;
  }
}

TEST(InfraredScene, AMirroredCameraShowsTheMirroredPicture) {
  const InfraredScene scene = setting().scene();
  for (const std::size_t camera : {std::size_t{0}, std::size_t{2}}) {
    const Picture left = draw(scene, camera);
    Picture right = draw(scene, camera + 1);
    for (int y = 0; y < kSide; ++y) std::reverse(right.begin() + y * kSide, right.begin() + (y + 1) * kSide);
    EXPECT_LT(difference(left, right), 0.06) << camera;  // Noise of the skin is not mirrored.
  }
}

TEST(InfraredScene, GivesTheSameBitsOnAnyThread) {
  const InfraredScene scene = setting().scene();
  std::vector<Picture> together(4);
  {
    std::vector<std::jthread> threads;
    for (std::size_t camera = 0; camera < 4; ++camera)
      threads.emplace_back([&, camera] { together[camera] = draw(scene, camera); });
  }
  const InfraredScene again = setting().scene();
  for (std::size_t camera = 0; camera < 4; ++camera) EXPECT_EQ(together[camera], draw(again, camera));
}

TEST(InfraredScene, ClosedLidsHideThePupilAndItsGlints) {
  InfraredScene scene = setting().scene({.lash_cover = 0});
  scene.set_pupils({2.5e-3F, 2.5e-3F});
  const auto darkest = [](const Picture& picture) {
    // Of the eye's surroundings.
    float least = 1e9F;
    for (int y = 40; y < 80; ++y)
      for (int x = 30; x < 80; ++x) least = std::min(least, picture[static_cast<std::size_t>(y * kSide + x)]);
    return least;
  };
  const Picture open = draw(scene, 0);
  const std::vector<Vec3f> shut = setting().posed({face::shape("eyeBlink_L"), face::shape("eyeBlink_R")}, 1);
  scene.pose(shut, shut, {});
  scene.light(setting().lamps, 0.1F, setting().lenses);
  const Picture closed = draw(scene, 0);
  EXPECT_LT(darkest(open), 0.25F * darkest(closed));
  EXPECT_GT(difference(open, closed), 0.03);
}

TEST(InfraredScene, ThePupilGoesWhereTheEyeLooks) {
  InfraredScene scene = setting().scene({.lash_cover = 0});
  scene.set_pupils({2.5e-3F, 2.5e-3F});
  const auto pupil_x = [&](std::size_t look) {
    const std::vector<Vec3f> turned = setting().posed({look}, 0.5F);
    scene.pose(turned, turned, {});
    scene.light(setting().lamps, 0.1F, setting().lenses);
    const Picture picture = draw(scene, 0);
    // The middle of what is nearly black in the eye's surroundings.
    double sum = 0, count = 0;
    const double dark = 0.06 * *std::ranges::max_element(picture);
    for (int y = 35; y < 80; ++y)
      for (int x = 25; x < 80; ++x)
        if (const float light = picture[static_cast<std::size_t>(y * kSide + x)]; light < dark) {
          sum += x;
          ++count;
        }
    EXPECT_GT(count, 5);
    return sum / count;
  };
  // A camera that looks at a face sees its left on the right.
  EXPECT_GT(pupil_x(face::shape("eyeLookOut_L")), pupil_x(face::shape("eyeLookIn_L")) + 4);
}

TEST(InfraredScene, AThingBeforeALampThrowsAShadow) {
  // A card close before the left mouth camera and its lamps.
  InfraredThing card{.vertices = 4, .triangles = {{0, 1, 2}, {0, 2, 3}}, .albedo = 0.5F};
  const std::vector<Vec3f> away(4, Vec3f(0, 0, -10));
  const Vec3f middle(0.021F, -0.004F, 0.140F);
  const std::vector<Vec3f> there = {middle + Vec3f(-0.015F, -0.015F, 0), middle + Vec3f(0.015F, -0.015F, 0),
                                    middle + Vec3f(0.015F, 0.015F, 0), middle + Vec3f(-0.015F, 0.015F, 0)};
  InfraredScene scene(setting().face, {.things = {card}}, setting().cameras_m);
  const auto right_view = [&](const std::vector<Vec3f>& things) {
    scene.pose(setting().face.neutral_m, setting().face.neutral_m, things);
    scene.light(setting().lamps, 0.01F, setting().lenses);
    return draw(scene, 3);
  };
  const Picture lit = right_view(away), shaded = right_view(there);
  EXPECT_LT(mean(shaded), 0.97 * mean(lit));
  // And seen by the camera that it stands before.
  scene.pose(setting().face.neutral_m, setting().face.neutral_m, away);
  scene.light(setting().lamps, 0.01F, setting().lenses);
  const Picture free = draw(scene, 2);
  scene.pose(setting().face.neutral_m, setting().face.neutral_m, there);
  scene.light(setting().lamps, 0.01F, setting().lenses);
  EXPECT_GT(difference(free, draw(scene, 2)), 0.1);
}

TEST(InfraredScene, AFaceThatMovesIsSeenRowByRow) {
  InfraredScene scene = setting().scene();
  const std::vector<Vec3f> shut = setting().posed({face::shape("jawOpen")}, 0);
  const std::vector<Vec3f> open = setting().posed({face::shape("jawOpen")}, 0.4F);
  const auto view = [&](const std::vector<Vec3f>& first, const std::vector<Vec3f>& last) {
    scene.pose(first, last, {});
    scene.light(setting().lamps, 0.1F, setting().lenses);
    return draw(scene, 2, 0.3F);
  };
  const Picture still = view(shut, shut), opening = view(shut, open);
  // The upper rows are early, where hardly anything has moved; the jaw is late.
  const auto part = [](const Picture& a, const Picture& b, int from, int to) {
    return difference(Picture(a.begin() + from * kSide, a.begin() + to * kSide),
                      Picture(b.begin() + from * kSide, b.begin() + to * kSide));
  };
  EXPECT_LT(part(still, opening, 0, 20), 0.02);
  EXPECT_GT(part(still, opening, 50, 80), 0.05);
}

TEST(InfraredScene, SpectaclesMirrorLamps) {
  InfraredWearer wearer;
  for (const face::Eyeball& eye : setting().face.eyes)
    wearer.glasses.push_back(
        {.centre_m = eye.centre_m + Vec3f(0, 0, 0.025F), .forward = Vec3f(0, -0.1F, 1).normalized()});
  const Picture with = draw(setting().scene(std::move(wearer)), 0), without = draw(setting().scene(), 0);
  EXPECT_GT(*std::ranges::max_element(with), 2 * *std::ranges::max_element(without));
}

}  // namespace
}  // namespace mien::render::infrared_scene_test
