#include "lab/imu/ablation/ablation_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include "mien/builtin_face/builtin_face.h"
#include "mien/core/files.h"
#include "tests/folder.h"
#include "tests/lab/imu/untrained.h"
#include "tests/project_path.h"
#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::ablation_study_test {
namespace {

AblationRequest small(std::vector<std::string> rows) {
  AblationRequest request;
  request.rig = project_path("rigs/default.toml");
  request.rows = std::move(rows);
  request.seeds = 2;
  request.steps = 6;
  request.data.performers = 6;
  request.data.validation_performers = 1;
  request.data.seconds = request.data.device_seconds = 2;
  request.data.device_share = 0.2;
  request.test_people = 2;
  request.test_seconds = 2;
  return request;
}

TEST(Ablation, TrainsEveryRowWithEverySeedAndTriesAllOnTheSamePeople) {
  test::Untrained untrained;
  const auto study =
      study_ablation(small({"five_sensors", "third_of_people"}), untrained.trainer(), no_progress);
  ASSERT_TRUE(study) << study.error().message();
  ASSERT_EQ(untrained.asked.size(), 6U);
  ASSERT_EQ(study->rows.size(), 3U);
  EXPECT_EQ(untrained.data.at("five_sensors-1").train.sensors.size(), 5U);
  // Others of the people for each seed, and the same whole for the base.
  std::set<std::uint32_t> first, second;
  for (const dataset::Sequence& s : untrained.data.at("third_of_people-1").train.sequences)
    first.insert(s.performer);
  for (const dataset::Sequence& s : untrained.data.at("third_of_people-2").train.sequences)
    second.insert(s.performer);
  EXPECT_EQ(first, (std::set<std::uint32_t>{0, 3}));
  EXPECT_EQ(second, (std::set<std::uint32_t>{1, 4}));
  EXPECT_EQ(untrained.asked[0].data_key, untrained.asked[1].data_key);
  EXPECT_NE(untrained.asked[0].recipe, untrained.asked[1].recipe);
  EXPECT_NE(untrained.asked[4].data_key, untrained.asked[5].data_key);

  for (const AblationResult& row : study->rows) {
    for (const TestSet set : {TestSet::device, TestSet::lab, TestSet::strangers}) {
      ASSERT_EQ(row.on(set).pve_mm.size(), 2U);
      EXPECT_EQ(row.on(set).pve_mm[0].size(), 2U);
      EXPECT_GT(row.on(set).mse[1][1], 0);
    }
    EXPECT_TRUE(row.on(TestSet::recorded).empty());
  }
  // Five sensors tell less than eleven by the bound, whatever the networks are.
  EXPECT_GT(study->rows[1].bound_mse, 1.05 * study->rows[0].bound_mse);
  EXPECT_EQ(study->rows[2].bound_mse, study->rows[0].bound_mse);
  EXPECT_FALSE(change_of(*study, study->rows[0], TestSet::device));
  EXPECT_TRUE(change_of(*study, study->rows[1], TestSet::device));
  EXPECT_FALSE(change_of(*study, study->rows[2], TestSet::seen)) << "others are seen by each";
  const measure::Report page = ablation_report(*study, "", "a test");
  EXPECT_NE(page.html().find("linear bound, one frame"), std::string::npos);
}

/// Two sensors are quicker than eleven.
AblationRequest of_two_sensors(const mien::test::Folder& folder, std::vector<std::string> rows) {
  AblationRequest request = small(std::move(rows));
  request.rig = folder / "rig.toml";
  request.seeds = 1;
  request.test_people = 1;
  EXPECT_TRUE(write_file(request.rig, virt::test::kRig));
  return request;
}

TEST(Ablation, RowsThatDifferInHowTheyAreAskedShareTheirNetworksAndAllIsTheSameAgain) {
  const mien::test::Folder folder;
  test::Untrained one, two;
  const AblationRequest request = of_two_sensors(folder, {"diffusion", "no_overlap"});
  const auto first = study_ablation(request, one.trainer(), no_progress);
  const auto again = study_ablation(request, two.trainer(), no_progress);
  ASSERT_TRUE(first) << first.error().message();
  ASSERT_TRUE(again) << again.error().message();
  EXPECT_EQ(one.asked.size(), 2U);
  ASSERT_EQ(first->rows.size(), 3U);
  for (std::size_t t = 0; t < one.asked.size(); ++t) {
    EXPECT_EQ(one.asked[t].recipe, two.asked[t].recipe);
    EXPECT_EQ(one.asked[t].data_key, two.asked[t].data_key);
  }
  for (std::size_t r = 0; r < first->rows.size(); ++r)
    EXPECT_EQ(first->rows[r].on(TestSet::strangers).pve_mm, again->rows[r].on(TestSet::strangers).pve_mm);
}

TEST(Ablation, OfFewPeopleAndManySeedsTriesAsManyOfEach) {
  // Ten people in three parts: four, three and three.
  const mien::test::Folder folder;
  test::Untrained untrained;
  AblationRequest request = of_two_sensors(folder, {"third_of_people"});
  request.seeds = 3;
  request.data.performers = 10;
  const auto study = study_ablation(request, untrained.trainer(), no_progress);
  ASSERT_TRUE(study) << study.error().message();
  for (const std::vector<double>& seed : study->rows[1].on(TestSet::seen).pve_mm) EXPECT_EQ(seed.size(), 3U);
}

TEST(Ablation, TriesShippedModelsAndRecordings) {
  const mien::test::Folder folder;
  test::Untrained untrained;
  AblationRequest request = of_two_sensors(folder, {"third_of_people"});
  request.seeds = 2;
  request.shipped.push_back({"a model of before", tracker::test::tiny_causal_model({"mentalis"}, 9)});
  for (const int frames : {150, 200})
    request.recorded.push_back({virt::test::talking(frames), builtin_face::default_builtin()});
  const auto study = study_ablation(request, untrained.trainer(), no_progress);
  ASSERT_TRUE(study) << study.error().message();
  ASSERT_EQ(study->shipped.size(), 1U);
  const AblationResult& shipped = study->shipped.front();
  EXPECT_EQ(shipped.on(TestSet::device).pve_mm.size(), 1U);
  EXPECT_TRUE(shipped.on(TestSet::seen).empty());
  EXPECT_FALSE(change_of(*study, shipped, TestSet::device));
  for (const AblationResult& row : study->rows) {
    EXPECT_EQ(row.on(TestSet::recorded).pve_mm.front().size(), 2U);
    // Two recordings are no sample of people.
    for (const std::vector<double>& seed : figures_of(row, TestSet::recorded, &SeedErrors::pve_mm))
      EXPECT_EQ(seed.size(), 1U);
  }
  EXPECT_TRUE(change_of(*study, study->rows[1], TestSet::recorded, &SeedErrors::mse));
}

TEST(Ablation, DataOfTakesAreKnownByTheirFiles) {
  const mien::test::Folder folder;
  AblationRequest request = of_two_sensors(folder, {"takes_alone"});
  request.takes = folder / "takes";
  std::filesystem::create_directories(request.takes);
  std::vector<std::vector<std::string>> keys;
  const TrainShort asked = [&](std::span<const ShortTraining> trainings,
                               const Progress&) -> Result<std::vector<model::ModelFile>> {
    keys.emplace_back();
    std::vector<model::ModelFile> out;
    for (const ShortTraining& training : trainings) {
      keys.back().push_back(training.data_key);
      out.push_back(tracker::test::tiny_causal_model({"mentalis"}));
    }
    return out;
  };
  for (const char* content : {"one", "one", "another"}) {
    // Written once for the first two.
    if (keys.size() != 1) {
      ASSERT_TRUE(write_file(request.takes / "ada.mien", std::string(content)));
    }
    const auto study = study_ablation(request, asked, no_progress);
    ASSERT_TRUE(study) << study.error().message();
  }
  ASSERT_EQ(keys[0].size(), 2U);
  EXPECT_EQ(keys[0], keys[1]);
  EXPECT_EQ(keys[0][0], keys[2][0]);
  EXPECT_NE(keys[0][1], keys[2][1]);
}

TEST(Ablation, SaysWhatItCannotDo) {
  test::Untrained untrained;
  EXPECT_EQ(study_ablation(small({"six_sensors"}), untrained.trainer(), no_progress).error().code,
            ErrorCode::not_found);
  AblationRequest request = small({});
  request.rig = project_path("rigs/eyewear.toml");
  EXPECT_EQ(study_ablation(request, untrained.trainer(), no_progress).error().code, ErrorCode::mismatch);
  EXPECT_TRUE(untrained.asked.empty());
}

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
  EXPECT_TRUE(has("takes_too"));
  for (const char* none : {"five_sensors", "no_frontalis", "no_buccinator", "one_side"})
    EXPECT_FALSE(has(none)) << none;
}

TEST(AblationRows, ChosenOnesHaveTheBaseBeforeThem) {
  const auto rows =
      chosen_rows(default_rig(), false, std::array<std::string, 2>{"diffusion", "five_sensors"});
  ASSERT_TRUE(rows) << rows.error().message();
  std::vector<std::string> names;
  for (const AblationRow& one : *rows) names.push_back(one.name);
  EXPECT_THAT(names, ElementsAre("base", "five_sensors", "diffusion"));
  const auto unknown = chosen_rows(default_rig(), false, std::array<std::string, 1>{"five_sensor"});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
  EXPECT_NE(unknown.error().what.find("did you mean five_sensors?"), std::string::npos);
  const auto without_takes = chosen_rows(default_rig(), false, std::array<std::string, 1>{"takes_too"});
  ASSERT_FALSE(without_takes);
  EXPECT_EQ(without_takes.error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::lab::ablation_study_test
