#include "mien/virtual/imu/skin_site.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/units.h"
#include "mien/face/ict_import.h"
#include "tests/project_path.h"

namespace mien::virt::skin_site_test {
namespace {

sensor::Rig default_rig() {
  return sensor::read_rig(project_path("rigs/default.toml")).value();
}

const std::vector<SkinSite>& builtin_sites_of_default_rig() {
  static const std::vector<SkinSite> sites = skin_sites(builtin_face::make_builtin(), default_rig()).value();
  return sites;
}

TEST(SkinSites, OneASensorOnTheSkinFacingOutwards) {
  const auto& sites = builtin_sites_of_default_rig();
  const sensor::Rig rig = default_rig();
  ASSERT_EQ(sites.size(), rig.sensors.size());
  for (std::size_t s = 0; s < sites.size(); ++s) {
    EXPECT_EQ(sites[s].sensor, rig.sensors[s].name);
    if (rig.sensors[s].side == 'L') {
      EXPECT_GT(sites[s].position_m.x(), 0.005) << sites[s].sensor;
    }
    if (rig.sensors[s].side == 'R') {
      EXPECT_LT(sites[s].position_m.x(), -0.005) << sites[s].sensor;
    }
    if (rig.sensors[s].role == "face") {
      EXPECT_GT(sites[s].normal.z(), 0) << sites[s].sensor;
    }
  }
}

TEST(SkinSites, NeutralIsNoRotationAndCovarianceIsLinear) {
  for (const SkinSite& site : builtin_sites_of_default_rig()) {
    EXPECT_LT(log_rotation(site.rotation({})).norm(), 1e-6);
    face::BlendshapeWeights weights;
    weights[face::shape("jawOpen")] = 0.4F;
    weights[face::shape("mouthSmile_L")] = 0.3F;
    const Vec3 moved = site.position(weights) - site.position({});
    const Vec3 expected = 0.4 * site.shape_shift_m[face::shape("jawOpen")] +
                          0.3 * site.shape_shift_m[face::shape("mouthSmile_L")];
    EXPECT_LT((moved - expected).norm(), 1e-6);
  }
}

TEST(SkinSites, PlacementMovesTheSiteAlongTheSkin) {
  const sensor::Rig rig = default_rig();
  std::vector<Vec3> offsets(rig.sensors.size(), Vec3(0, 0.004, 0));
  const auto moved = skin_sites(builtin_face::make_builtin(), rig, offsets);
  ASSERT_TRUE(moved.has_value());
  for (std::size_t s = 0; s < rig.sensors.size(); ++s) {
    const double shift = ((*moved)[s].position_m - builtin_sites_of_default_rig()[s].position_m).norm();
    EXPECT_GT(shift, 0.001) << rig.sensors[s].name;
    EXPECT_LT(shift, 0.010) << rig.sensors[s].name;
  }
  offsets.pop_back();
  EXPECT_EQ(skin_sites(builtin_face::make_builtin(), rig, offsets).error().code, ErrorCode::mismatch);
}

TEST(DrawKinematics, SpreadIsAroundTheMesh) {
  const auto& sites = builtin_sites_of_default_rig();
  const KinematicsSpread none{0, 0};
  const auto same = draw_kinematics(sites, none, Random(1));
  face::BlendshapeWeights jaw;
  jaw[face::shape("jawOpen")] = 1;
  for (std::size_t s = 0; s < sites.size(); ++s)
    EXPECT_LT(angle_between(same[s].rotation(jaw), sites[s].rotation(jaw)), 1e-6);

  double ratio = 0;
  constexpr int kDraws = 200;
  const std::size_t site = 6;  // Lower zygomaticus, which the jaw turns well.
  for (int d = 0; d < kDraws; ++d) {
    const auto drawn = draw_kinematics({sites[site]}, {}, Random(static_cast<std::uint64_t>(d)));
    ratio += log_rotation(drawn[0].rotation(jaw)).norm() / log_rotation(sites[site].rotation(jaw)).norm();
  }
  EXPECT_NEAR(ratio / kDraws, 1, 0.15);
  EXPECT_NE(draw_kinematics(sites, {}, Random(1))[site].rotation(jaw).coeffs(),
            draw_kinematics(sites, {}, Random(2))[site].rotation(jaw).coeffs());
}

TEST(SkinSites, TheRigsPlacesAreTheBuiltInHeads) {
  const sensor::Rig rig = default_rig();
  for (const builtin_face::BuiltinSite& site : builtin_face::builtin_sites()) {
    const auto sensor = rig.find(site.name);
    ASSERT_TRUE(sensor) << site.name;
    ASSERT_TRUE(rig.sensors[*sensor].position_m) << site.name;
    EXPECT_LT((*rig.sensors[*sensor].position_m - site.position_m).norm(), 1e-6) << site.name;
  }
}

TEST(SkinSites, ASkinTooThinForASensorIsRefused) {
  face::Face face = builtin_face::make_builtin();
  face.origin = face::Origin::other;
  for (Vec3f& vertex : face.neutral_m) vertex = 1e-3F * vertex;  // A head of a fifth of a millimetre.
  const auto refused = skin_sites(face, default_rig());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
}

TEST(SkinSites, ForeignFaceWithoutLandmarksIsRefused) {
  face::Face face = builtin_face::make_builtin();
  face.name = "visitor";
  face.origin = face::Origin::other;
  EXPECT_TRUE(skin_sites(face, default_rig()).has_value());
  face.has_landmarks = false;
  EXPECT_EQ(skin_sites(face, default_rig()).error().code, ErrorCode::not_found);
}

/// Where the real model has been unpacked, its sites turn as the published measurement says.
TEST(SkinSites, IctMatchesTheMeasuredRotations) {
  const char* folder = std::getenv("MIEN_ICT_FOLDER");
  if (folder == nullptr || !std::filesystem::exists(folder))
    GTEST_SKIP() << "set MIEN_ICT_FOLDER to an ICT-FaceKit FaceXModel folder to compare with the real mesh";
  const auto face = face::import_ict(folder);
  ASSERT_TRUE(face.has_value()) << face.error().message();
  const auto sites = skin_sites(*face, default_rig());
  ASSERT_TRUE(sites.has_value());
  const std::map<std::string, double> best_deg = {
      {"browDown_L", 9.2},   {"browInnerUp_L", 5.0}, {"eyeSquint_L", 3.7},   {"cheekPuff_L", 12.7},
      {"jawOpen", 17.6},     {"jawForward", 11.4},   {"mouthSmile_L", 33.7}, {"mouthLeft", 25.4},
      {"mouthClose", 22.6},  {"mouthPucker", 9.3},   {"mouthFunnel", 7.0},   {"mouthShrugLower", 12.2},
      {"noseSneer_L", 15.3}, {"mouthFrown_L", 12.1}};
  for (const auto& [name, expected] : best_deg) {
    face::BlendshapeWeights weights;
    weights[face::shape_index(name)] = 1;
    double best = 0;
    for (const SkinSite& site : *sites)
      best = std::max(best, log_rotation(site.rotation(weights)).norm() / kRadPerDeg);
    EXPECT_NEAR(best, expected, 0.25 * expected) << name;
  }
}

TEST(SkinSites, TurnedSkinTurnsAsFarAboutAnotherAxis) {
  const auto& sites = builtin_sites_of_default_rig();
  const auto turned = draw_turns(sites, 10 * kRadPerDeg, Random(3));
  const auto same = draw_turns(sites, 0, Random(3));
  face::BlendshapeWeights weights;
  weights[face::shape("jawOpen")] = 0.5F;
  weights[face::shape("mouthSmile_L")] = 0.7F;
  double largest = 0;
  for (std::size_t s = 0; s < sites.size(); ++s) {
    const Vec3 was = log_rotation(sites[s].rotation(weights));
    const Vec3 is = log_rotation(turned[s].rotation(weights));
    EXPECT_NEAR(is.norm(), was.norm(), 1e-6) << sites[s].sensor;
    EXPECT_LT((log_rotation(same[s].rotation(weights)) - was).norm(), 1e-6);
    EXPECT_LT(log_rotation(turned[s].rotation({})).norm(), 1e-6) << "neutral is neutral";
    const double moved = (sites[s].position(weights) - sites[s].position({})).norm();
    EXPECT_NEAR((turned[s].position(weights) - turned[s].position({})).norm(), moved, 1e-9);
    if (was.norm() > 0.02)
      largest = std::max(largest, std::acos(std::min(1.0, was.dot(is) / was.squaredNorm())));
  }
  EXPECT_GT(largest, 4 * kRadPerDeg);
  EXPECT_LT(largest, 40 * kRadPerDeg);
}

}  // namespace
}  // namespace mien::virt::skin_site_test
