#include "mien/mocap/rigid_points.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "mien/builtin_face/builtin_face.h"
#include "mien/mocap/marker_track.h"
#include "tests/project_path.h"

namespace mien::mocap::rigid_points_test {
namespace {

const RigidPoints kBody = {.place_m = {Vec3(0, 0, 0.1), Vec3(0.03, 0, 0.1), Vec3(0, 0.04, 0.1),
                                       Vec3(-0.03, 0.02, 0.09), Vec3(0.01, -0.03, 0.12)},
                           .slack_m = {1e-3, 1e-3, 1e-3, 1e-3, 1e-3}};

Eigen::Isometry3d pose() {
  Eigen::Isometry3d camera_head = Eigen::Isometry3d::Identity();
  camera_head.linear() = Eigen::AngleAxisd(2.5, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  camera_head.translation() = Vec3(1, -2, 3);
  return camera_head;
}

std::vector<Vec3f> seen() {
  std::vector<Vec3f> points;
  for (const Vec3& place : kBody.place_m) points.emplace_back((pose() * place).cast<float>());
  return points;
}

void expect_found(const std::optional<Eigen::Isometry3d>& fit) {
  ASSERT_TRUE(fit);
  EXPECT_TRUE(((*fit) * pose()).isApprox(Eigen::Isometry3d::Identity(), 1e-4));
}

TEST(FitRigid, FindsThePose) {
  expect_found(fit_rigid(kBody, seen()));
}

TEST(FitRigid, ThreeAreEnoughAndTwoAreNot) {
  std::vector<Vec3f> points = seen();
  points[1] = points[4] = kLostMarker;
  expect_found(fit_rigid(kBody, points));
  points[0] = kLostMarker;
  EXPECT_FALSE(fit_rigid(kBody, points));
  EXPECT_FALSE(fit_rigid(kBody, {}));
}

TEST(FitRigid, OneThatIsElsewhereIsLeftOut) {
  std::vector<Vec3f> points = seen();
  points[2] += Vec3f(0.05F, 0.03F, 0);
  expect_found(fit_rigid(kBody, points));
}

TEST(FitRigid, PointsInOneLineTellNothing) {
  const RigidPoints line = {.place_m = {Vec3(0, 0, 0), Vec3(0.05, 0, 0), Vec3(0.1, 0.001, 0)},
                            .slack_m = {1e-3, 1e-3, 1e-3}};
  EXPECT_FALSE(
      fit_rigid(line, std::vector<Vec3f>{Vec3f(0, 0, 0), Vec3f(0.05F, 0, 0), Vec3f(0.1F, 0.001F, 0)}));
}

// docs/method/markers.md names these; rigs/markers.toml and the built-in face decide.
TEST(ReferenceMarkers, AreThoseThatExpressionsHardlyMove) {
  const auto set = builtin_face::read_markers(project_path("rigs/markers.toml"));
  ASSERT_TRUE(set);
  const auto placed = builtin_face::PlacedMarkers::place(builtin_face::make_builtin(), *set);
  ASSERT_TRUE(placed);
  std::vector<std::string> names;
  for (const ReferenceMarker& reference : reference_markers(*placed))
    names.push_back(set->markers[reference.marker].name);
  std::ranges::sort(names);
  EXPECT_EQ(names, (std::vector<std::string>{"forehead_L", "forehead_R", "lid_lower_L", "lid_lower_R",
                                             "nose_bridge", "nose_tip", "nostril_L", "nostril_R"}));
}

}  // namespace
}  // namespace mien::mocap::rigid_points_test
