#include "mien/virtual/imu/skin_motion.h"

#include <gtest/gtest.h>

#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::skin_motion_test {
namespace {

TEST(StudySkinMotion, IsTheSameOnAnyNumberOfThreads) {
  const sensor::Rig rig = test::three_sensors();
  SkinMotionRequest request{.performers = 3, .seconds = 8, .threads = 1};
  const auto one = study_skin_motion(request, rig, no_progress);
  ASSERT_TRUE(one) << one.error().message();
  request.threads = 3;
  const auto three = study_skin_motion(request, rig, no_progress);
  ASSERT_TRUE(three);
  EXPECT_EQ(sensor::write_skin(*one), sensor::write_skin(*three));
  EXPECT_EQ(one->sensors, rig.face_sensor_names());
  EXPECT_GT(one->factor_deg.diagonal().minCoeff(), 0);
}

TEST(StudySkinMotion, TheDefaultRigsTableIsOfItsSkin) {
  const sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  ASSERT_TRUE(rig.skin);
  const auto skin = study_skin_motion({.performers = 100, .seconds = 15}, rig, no_progress);
  ASSERT_TRUE(skin) << skin.error().message();
  // Fewer people than those of the table, which is of a head of other proportions: what the live model learnt
  // by.
  for (Eigen::Index i = 0; i < skin->mean_deg.size(); ++i) {
    const double told = rig.skin->factor_deg.row(i).norm(), found = skin->factor_deg.row(i).norm();
    EXPECT_NEAR(found / told, 1, 0.3) << i;
    EXPECT_NEAR(skin->mean_deg[i], rig.skin->mean_deg[i], 0.3 * told) << i;
  }
  const sensor::Rig both = sensor::read_rig(project_path("rigs/imu_eyewear.toml")).value();
  ASSERT_TRUE(both.skin);
  EXPECT_EQ(sensor::write_skin(*both.skin), sensor::write_skin(*rig.skin));
}

TEST(StudySkinMotion, NeedsSkin) {
  sensor::Rig rig = test::three_sensors();
  for (sensor::Mount& mount : rig.sensors) mount.role = "head";
  const auto none = study_skin_motion({.performers = 1, .seconds = 2}, rig, no_progress);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::bad_usage);
}

TEST(StudySkinMotion, StopsWhenTold) {
  const auto stopped = study_skin_motion({.performers = 500, .seconds = 20}, test::three_sensors(),
                                         [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::virt::skin_motion_test
