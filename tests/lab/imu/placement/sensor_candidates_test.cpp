#include "lab/imu/placement/sensor_candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "lab/imu/placement/paper_sites.h"
#include "lab/imu/placement/placement_study.h"
#include "tests/project_path.h"

namespace mien::lab::sensor_candidates_test {
namespace {

using testing::HasSubstr;

/// A rig of one sensor on the face, here.
sensor::Rig rig_with(const Vec3& position_m, const std::string& name = "cheek") {
  return sites_rig({{.name = name, .area = "cheek", .side = 'L', .position_m = position_m}});
}

const Vec3 kCheek(0.0347, -0.0190, 0.0999);  // zygomaticus_lower_L, on the skin.

TEST(DenseCandidates, AreEvenAndMirrored) {
  const std::vector<SensorCandidate> grid = dense_candidates(0.012);
  ASSERT_GT(grid.size(), 80U);
  std::set<std::string> names;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_TRUE(names.insert(grid[i].name).second) << grid[i].name;
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT((grid[i].position_m - grid[j].position_m).norm(), 0.0119)
          << grid[i].name << " and " << grid[j].name;
    if (grid[i].side == 'M') {
      EXPECT_EQ(grid[i].position_m.x(), 0);
    } else if (grid[i].side == 'R') {
      ASSERT_LT(i + 1, grid.size());
      const Vec3& left = grid[i + 1].position_m;
      EXPECT_EQ(grid[i].position_m, Vec3(-left.x(), left.y(), left.z()));
      EXPECT_EQ(grid[i + 1].side, 'L');
    }
  }
  const std::vector<std::size_t> mirror = mirror_candidates(grid);
  for (std::size_t i = 0; i < grid.size(); ++i) EXPECT_EQ(mirror[mirror[i]], i);
}

TEST(DenseCandidates, AreWhereSomethingCanBeGlued) {
  const auto on_skin = candidates_of(sites_rig(dense_candidates(0.015)));
  ASSERT_TRUE(on_skin) << on_skin.error().message();
  for (const SensorCandidate& candidate : *on_skin) {
    const Vec3 p = candidate.position_m;
    EXPECT_FALSE(std::abs(p.x()) < 0.022 && p.y() > -0.040 && p.y() < -0.028) << candidate.name;  // Lips.
    EXPECT_FALSE(std::abs(std::abs(p.x()) - 0.032) < 0.012 && std::abs(p.y() - 0.040) < 0.012)
        << candidate.name;  // Lids.
    EXPECT_GT(p.z(), 0.02) << candidate.name;
    EXPECT_LT(p.y(), 0.1) << candidate.name;
  }
}

TEST(CandidatesOf, ReadThePapersAndTheDefaultRigs) {
  const auto paper = candidates_of(sensor::read_rig(project_path("rigs/candidates.toml")).value());
  ASSERT_TRUE(paper) << paper.error().message();
  EXPECT_EQ(paper->size(), 25U);  // Twelve on both sides, and the chin.
  const auto rig = candidates_of(sensor::read_rig(project_path("rigs/default.toml")).value());
  ASSERT_TRUE(rig);
  ASSERT_EQ(rig->size(), 11U);
  // Those that the paper uses are the default rig's.
  std::size_t used = 0;
  for (const SensorCandidate& candidate : *paper) {
    const PaperSite* site = paper_site_of(candidate);
    ASSERT_NE(site, nullptr) << candidate.name;
    if (!site->used) continue;
    ++used;
    const bool is_there = std::ranges::any_of(*rig, [&](const SensorCandidate& worn) {
      return worn.position_m == candidate.position_m && worn.ict_vertex == candidate.ict_vertex;
    });
    EXPECT_TRUE(is_there) << candidate.name;
  }
  EXPECT_EQ(used, 9U);
}

TEST(CandidatesOf, RefusesWhatCannotBe) {
  const auto off = candidates_of(rig_with(kCheek + Vec3(0, 0, 0.03), "floating"));
  ASSERT_FALSE(off);
  EXPECT_EQ(off.error().code, ErrorCode::out_of_range);
  EXPECT_THAT(off.error().message(), HasSubstr("floating"));
  EXPECT_THAT(off.error().message(), HasSubstr("mm off the skin"));

  const auto inside = candidates_of(rig_with(Vec3(0.01, 0.02, 0.04), "brain"));
  ASSERT_FALSE(inside);
  EXPECT_EQ(inside.error().code, ErrorCode::out_of_range);
  EXPECT_THAT(inside.error().message(), HasSubstr("sensor brain"));
  EXPECT_THAT(inside.error().message(), HasSubstr("inside the head"));

  const auto twice = candidates_of(sites_rig(
      {{.name = "one", .position_m = kCheek}, {.name = "two", .position_m = kCheek + Vec3(0, 0.001, 0)}}));
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().code, ErrorCode::bad_usage);
  EXPECT_THAT(twice.error().message(), HasSubstr("sensors one and two"));

  sensor::Rig none = rig_with(kCheek);
  none.sensors.front().role = "head";
  const auto nobody = candidates_of(none);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().code, ErrorCode::bad_usage);

  sensor::Rig somewhere = rig_with(kCheek, "nowhere");
  somewhere.sensors.front().position_m.reset();
  const auto unknown = candidates_of(somewhere);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
  EXPECT_THAT(unknown.error().message(), HasSubstr("nowhere"));
}

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

TEST(WornRigOf, NeedsAHeadAndSensors) {
  sensor::Rig headless = default_rig();
  std::erase_if(headless.sensors, [](const sensor::Mount& mount) { return mount.role == "head"; });
  const auto without = worn_rig_of(three_candidates(), headless, "three", {}, no_progress);
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().code, ErrorCode::not_found);
  const auto nobody = worn_rig_of({}, default_rig(), "none", {}, no_progress);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::lab::sensor_candidates_test
