#include "lab/imu/placement/placement_rig.h"

#include <gtest/gtest.h>

#include "lab/imu/placement/placement_study.h"
#include "tests/project_path.h"

namespace mien::lab::placement_rig_test {
namespace {

sensor::Rig default_rig() {
  return sensor::read_rig(project_path("rigs/default.toml")).value();
}

std::vector<SensorCandidate> three_candidates() {
  return {
      {.name = "cheek_07_R", .area = "cheek", .side = 'R', .position_m = Vec3(-0.03471, -0.01902, 0.0999)},
      {.name = "cheek_07_L", .area = "cheek", .side = 'L', .position_m = Vec3(0.03471, -0.01902, 0.0999)},
      {.name = "chin_01_M",
       .area = "chin",
       .side = 'M',
       .position_m = Vec3(0, -0.0686, 0.1093),
       .ict_vertex = 963}};
}

TEST(WornRigOf, ReadsBackEqualAndCanBeWorn) {
  const sensor::Rig base = default_rig();
  const auto rig =
      worn_rig_of(three_candidates(), base, "three", {.performers = 3, .seconds = 6}, no_progress);
  ASSERT_TRUE(rig) << rig.error().message();
  const std::string text = sensor::write_rig(*rig);
  const auto back = sensor::parse_rig(text, "three.toml");
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ(sensor::write_rig(*back), text);
  EXPECT_EQ(back->faults_toml, base.faults_toml);
  EXPECT_EQ(back->reference, "mastoid_L");
  EXPECT_EQ(back->face_sensor_names(), (std::vector<std::string>{"cheek_07_R", "cheek_07_L", "chin_01_M"}));
  ASSERT_TRUE(back->head_sensor());
  EXPECT_EQ(back->sensors[*back->head_sensor()].device, "02:4D:49:45:4E:03");
  EXPECT_EQ(back->sensors[0].device, "02:4D:49:45:4E:00");
  EXPECT_EQ(back->sensors[2].ict_vertex, 963);
  EXPECT_EQ(back->sensors[0].ict_vertex, -1);
  EXPECT_EQ(*back->sensors[0].position_m, Vec3(-0.0347, -0.0190, 0.0999));
  ASSERT_TRUE(back->skin);
  EXPECT_EQ(back->skin->sensors, back->face_sensor_names());
}

TEST(RigOf, NeedsAHeadAndSensors) {
  sensor::Rig headless = default_rig();
  std::erase_if(headless.sensors, [](const sensor::Mount& mount) { return mount.role == "head"; });
  const auto without = rig_of(three_candidates(), headless, "three");
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().code, ErrorCode::not_found);
  const auto nobody = rig_of({}, default_rig(), "none");
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().code, ErrorCode::bad_usage);
}

TEST(PlacementRecipe, HasDataThatReads) {
  const std::string recipe = placement_recipe();
  const std::size_t begin = recipe.find("[data]\n") + 7;
  const auto data =
      synthetic::parse_data_recipe(recipe.substr(begin, recipe.find("\n[optimiser]") - begin), "recipe");
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_GT(data->performers, 100);
}

}  // namespace
}  // namespace mien::lab::placement_rig_test
