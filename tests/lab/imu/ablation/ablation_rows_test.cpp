#include "lab/imu/ablation/ablation_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::ablation_rows_test {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

const sensor::Rig& default_rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  return rig;
}

const AblationRow& row(const std::vector<AblationRow>& rows, std::string_view name) {
  return *std::ranges::find(rows, name, &AblationRow::name);
}

TEST(AblationRows, OfTheDefaultRigAreThePapers) {
  const std::vector<AblationRow> rows = ablation_rows(default_rig(), true);
  EXPECT_EQ(rows.front().name, kAblationBase);
  EXPECT_EQ(rows.front().sensors, default_rig().face_sensor_names());
  EXPECT_THAT(row(rows, "five_sensors").sensors,
              UnorderedElementsAre("frontalis_R", "frontalis_L", "zygomaticus_lower_R", "zygomaticus_lower_L",
                                   "mentalis"));
  EXPECT_EQ(row(rows, "no_zygomaticus").sensors.size(), 7U);
  EXPECT_EQ(row(rows, "no_buccinator").sensors.size(), 8U);
  EXPECT_EQ(row(rows, "one_side").sensors.size(), 6U);
  std::set<std::string> names;
  for (const AblationRow& one : rows) {
    EXPECT_TRUE(names.insert(one.name).second) << one.name;
    EXPECT_FALSE(one.title.empty());
    EXPECT_FALSE(one.sensors.empty());
    EXPECT_EQ(3840 % one.window, 0U);
  }
}

TEST(AblationRows, OfOtherRigsAreThoseThatTheyHaveSensorsFor) {
  const std::vector<AblationRow> rows =
      ablation_rows(virt::test::three_sensors(), true);  // Chin and left cheek.
  const auto has = [&](std::string_view name) {
    return std::ranges::find(rows, name, &AblationRow::name) != rows.end();
  };
  EXPECT_TRUE(has("base"));
  EXPECT_TRUE(has("third_of_people"));
  for (const char* none : {"five_sensors", "no_frontalis", "no_buccinator", "one_side"})
    EXPECT_FALSE(has(none)) << none;
}

TEST(AblationRows, SayWhoseTakesTheyAre) {
  EXPECT_EQ(row(ablation_rows(default_rig(), true), "takes_alone").title, "stand-ins for takes alone");
  EXPECT_EQ(row(ablation_rows(default_rig(), false), "takes_alone").title, "people's takes alone");
}

TEST(AblationRows, ChosenOnesHaveTheBaseBeforeThem) {
  const auto rows = chosen_rows(default_rig(), true, std::array<std::string, 2>{"diffusion", "five_sensors"});
  ASSERT_TRUE(rows) << rows.error().message();
  std::vector<std::string> names;
  for (const AblationRow& one : *rows) names.push_back(one.name);
  EXPECT_THAT(names, ElementsAre("base", "five_sensors", "diffusion"));
  const auto unknown = chosen_rows(default_rig(), true, std::array<std::string, 1>{"five_sensor"});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
  EXPECT_NE(unknown.error().what.find("did you mean five_sensors?"), std::string::npos);
}

}  // namespace
}  // namespace mien::lab::ablation_rows_test
