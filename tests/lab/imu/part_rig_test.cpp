#include "lab/imu/part_rig.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/project_path.h"

namespace mien::lab::part_rig_test {
namespace {

const sensor::Rig& default_rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  return rig;
}

TEST(RigWithSensors, HasTheMarginalOfTheSkin) {
  const auto part =
      rig_with_sensors(default_rig(), std::array<std::string, 2>{"mentalis", "zygomaticus_lower_R"});
  ASSERT_TRUE(part) << part.error().message();
  // The rig's order, and the head's sensor.
  EXPECT_EQ(part->face_sensor_names(), (std::vector<std::string>{"zygomaticus_lower_R", "mentalis"}));
  EXPECT_TRUE(part->head_sensor());
  EXPECT_EQ(part->reference, default_rig().reference);
  const sensor::SkinMotion &whole = *default_rig().skin, &few = *part->skin;
  ASSERT_EQ(few.sensors, part->face_sensor_names());
  const Eigen::MatrixXd all = whole.factor_deg * whole.factor_deg.transpose(),
                        left = few.factor_deg * few.factor_deg.transpose();
  for (Eigen::Index a = 0; a < 3; ++a) {
    EXPECT_EQ(few.mean_deg[a], whole.mean_deg[18 + a]);      // zygomaticus_lower_R is the seventh.
    EXPECT_EQ(few.mean_deg[3 + a], whole.mean_deg[30 + a]);  // mentalis is the eleventh.
    for (Eigen::Index b = 0; b < 3; ++b) {
      EXPECT_NEAR(left(a, b), all(18 + a, 18 + b), 1e-9);
      EXPECT_NEAR(left(a, 3 + b), all(18 + a, 30 + b), 1e-9);
    }
  }
  const auto read = sensor::parse_rig(sensor::write_rig(*part), "part");
  ASSERT_TRUE(read) << read.error().message();
}

TEST(RigWithSensors, OfAllIsTheRig) {
  const auto same = rig_with_sensors(default_rig(), default_rig().face_sensor_names());
  ASSERT_TRUE(same);
  EXPECT_EQ(sensor::write_rig(*same), sensor::write_rig(default_rig()));
}

TEST(RigWithSensors, RefusesWhatItHasNot) {
  EXPECT_EQ(rig_with_sensors(default_rig(), {}).error().code, ErrorCode::bad_usage);
  const auto unknown = rig_with_sensors(default_rig(), std::array<std::string, 1>{"mastoid_L"});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
}

}  // namespace
}  // namespace mien::lab::part_rig_test
