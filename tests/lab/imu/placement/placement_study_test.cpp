#include "lab/imu/placement/placement_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lab/imu/short_training.h"
#include "mien/builtin_face/builtin_face.h"
#include "tests/lab/imu/untrained.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::placement_study_test {
namespace {

using testing::HasSubstr;
using testing::Not;

PlacementRigs rigs() {
  return {.paper_candidates = sensor::read_rig(project_path("rigs/candidates.toml")).value(),
          .paper = sensor::read_rig(project_path("rigs/default.toml")).value(),
          .own = {}};
}

PlacementRequest small_request() {
  PlacementRequest request;
  request.sensors = 5;
  request.spacing_m = 0.025;
  request.settings.most = 5;
  request.paper_sites.performers = 1;
  request.picture_px = 96;
  return request;
}

/// What networks of the paper's five were off, and of a greedy five that is a fifth better in *device*.
TrainedPlacement papers_five() {
  return {.name = "paper-five",
          .title = "the paper's five",
          .sensors = 5,
          .device = {.pve_mm = {{1.0, 1.2, 1.1}, {1.0, 1.2, 1.1}},
                     .mse = {{0.01, 0.012, 0.011}, {0.01, 0.012, 0.011}}},
          .lab = {.pve_mm = {{0.9, 1.1, 1.0}, {0.9, 1.1, 1.0}},
                  .mse = {{0.01, 0.012, 0.011}, {0.01, 0.012, 0.011}}}};
}

TrainedPlacement greedy_five() {
  TrainedPlacement ours = papers_five();
  ours.name = "greedy-five";
  ours.title = "greedy five";
  for (auto& seed : ours.device.pve_mm)
    for (double& pve_mm : seed) pve_mm *= 0.8;
  return ours;
}

TEST(StudyPlacement, TellsAllOfItWithoutTraining) {
  const PlacementRequest request = small_request();
  const auto study = study_placement(request, builtin_face::default_builtin(), rigs(), nullptr, no_progress);
  ASSERT_TRUE(study) << study.error().message();
  EXPECT_EQ(study->chosen.size(), 5U);
  EXPECT_EQ(study->choices, study->candidates.size());
  EXPECT_EQ(study->alone.size(), study->candidates.size());
  ASSERT_EQ(study->sets.size(), 5U);
  EXPECT_LT(study->sets[4].rms_vertex_mm, study->sets[0].rms_vertex_mm);
  EXPECT_LT(study->paper.rms_vertex_mm, study->paper_five.rms_vertex_mm);
  EXPECT_LT(study->left_right, 0.05);
  EXPECT_TRUE(study->trained.empty());
  EXPECT_EQ(study->not_trained, "");
  EXPECT_EQ(study->picture.width, 2 * request.picture_px);

  const auto report = placement_report(*study, request, "a test");
  ASSERT_TRUE(report);
  const std::string text = report->plain_text();
  EXPECT_THAT(text, HasSubstr("greedy 5"));
  EXPECT_THAT(text, HasSubstr("frontalis 1 *"));
  EXPECT_THAT(text, HasSubstr("Rank correlation"));
  EXPECT_THAT(report->html(), HasSubstr("Where to glue sensors"));
  EXPECT_THAT(report->html(), Not(HasSubstr("By short trainings")));
}

TEST(StudyPlacement, SaysWhereNoSetIsLargeEnoughToBeTrained) {
  PlacementRigs with_own = rigs();
  with_own.own =
      *rig_with_sensors(with_own.paper, std::vector<std::string>{"frontalis_R", "frontalis_L", "mentalis"});
  const TrainShort nobody = [](std::span<const ShortTraining>,
                               const Progress&) -> Result<std::vector<model::ModelFile>> {
    return fail(ErrorCode::internal, "nothing was to be trained");
  };
  PlacementRequest request = small_request();
  request.sensors = 3;
  const auto study =
      study_placement(request, builtin_face::default_builtin(), with_own, &nobody, no_progress);
  ASSERT_TRUE(study) << study.error().message();
  EXPECT_TRUE(study->trained.empty());
  EXPECT_THAT(study->not_trained, testing::StartsWith("No set was trained"));
  EXPECT_THAT(study->not_trained, HasSubstr("of eleven or five sensors"));
  const auto report = placement_report(*study, request, "a test");
  ASSERT_TRUE(report);
  EXPECT_THAT(report->html(), HasSubstr("No set was trained"));
  EXPECT_THAT(report->plain_text(), HasSubstr("No set was trained"));
}

TEST(PlacementVerdicts, NameTheBetterSetUnlessAmountsCompareNothing) {
  PlacementStudy study;
  study.trained = {greedy_five(), papers_five()};
  study.contests = {contest(study.trained[0], study.trained[1])};
  PlacementRequest request;
  EXPECT_THAT(placement_verdicts(study, request),
              testing::ElementsAre(testing::StartsWith("By vertex error greedy five beats the paper's")));
  request.quick = true;
  study.not_trained = "No set of eleven sensors was trained: the candidates give none.";
  EXPECT_THAT(placement_verdicts(study, request),
              testing::ElementsAre(HasSubstr("compare nothing"), study.not_trained));
}

TEST(PlacementTrainedTable, SaysHowLargeTheTrainingsWere) {
  PlacementStudy study;
  study.trained = {greedy_five(), papers_five()};
  PlacementTrainingRequest request;
  request.seeds = 2;
  request.steps = 345;
  request.data.performers = 67;
  request.test_people = 8;
  const measure::Table table = placement_trained_table(study, request);
  EXPECT_EQ(table.rows.size(), 2U);
  for (const char* amount : {"a set: 2;", "steps of each: 345", "performers: 67", "on 8 people"})
    EXPECT_THAT(table.caption, HasSubstr(amount));
}

TEST(StudyPlacement, ChoosesAmongOnesOwn) {
  PlacementRigs with_own = rigs();
  with_own.own = with_own.paper;  // The default rig's eleven as candidates.
  const auto study =
      study_placement(small_request(), builtin_face::default_builtin(), with_own, nullptr, no_progress);
  ASSERT_TRUE(study) << study.error().message();
  EXPECT_EQ(study->choices, 11U);
  for (const std::size_t i : study->chosen) EXPECT_LT(i, 11U);

  PlacementRequest many = small_request();
  many.sensors = 12;
  const auto too_many =
      study_placement(many, builtin_face::default_builtin(), with_own, nullptr, no_progress);
  ASSERT_FALSE(too_many);
  EXPECT_EQ(too_many.error().code, ErrorCode::bad_usage);
}

TEST(StudyPlacement, StopsWhenTold) {
  const auto stopped = study_placement(small_request(), builtin_face::default_builtin(), rigs(), nullptr,
                                       [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

TEST(Contest, NamesTheBetterOne) {
  const TrainedPlacement paper = papers_five(), ours = greedy_five();
  EXPECT_THAT(contest(ours, paper).verdict(),
              testing::StartsWith("By vertex error greedy five beats the paper's"));
  EXPECT_THAT(contest(paper, ours).verdict(), testing::StartsWith("By vertex error greedy five beats"));
  EXPECT_THAT(contest(paper, paper).verdict(), testing::StartsWith("By vertex error neither"));
}

TEST(TopShapes, AreThoseThatAreTold) {
  PosteriorOverPrior posterior;
  posterior.fill(1);
  EXPECT_EQ(top_shapes(posterior), "little of anything");
  posterior[face::shape("jawOpen")] = 0.5;
  posterior[face::shape("mouthClose")] = 0.9;
  EXPECT_EQ(top_shapes(posterior), "jawOpen 75 %, mouthClose 19 %");
}

PlacementTrainingRequest small_training() {
  PlacementTrainingRequest request;
  request.seeds = 2;
  request.steps = 6;
  request.data.performers = 3;
  request.data.validation_performers = 1;
  request.data.seconds = request.data.device_seconds = 2;
  request.test_people = 2;
  request.test_seconds = 2;
  return request;
}

TEST(TrainPlacements, GivesEachSetItsOwnDataOfTheSamePeople) {
  const sensor::Rig both = virt::test::three_sensors();
  const sensor::Rig one = *rig_with_sensors(both, std::vector<std::string>{"mentalis"});
  test::Untrained untrained;
  const std::vector<PlacementRig> rigs = {{"two", "two sensors", both}, {"one", "one sensor", one}};
  const auto trained = train_placements(small_training(), rigs, untrained.trainer(), no_progress);
  ASSERT_TRUE(trained) << trained.error().message();
  ASSERT_EQ(untrained.asked.size(), 4U);
  EXPECT_EQ(untrained.asked[0].data_key, untrained.asked[1].data_key);
  EXPECT_NE(untrained.asked[0].recipe, untrained.asked[1].recipe);
  EXPECT_TRUE(untrained.asked[0].recipe.starts_with("seed = 100\n"));
  EXPECT_TRUE(untrained.asked[1].recipe.starts_with("seed = 101\n"));
  EXPECT_NE(untrained.asked[0].data_key, untrained.asked[2].data_key);
  // The same budget and the same performances, whatever is worn.
  EXPECT_EQ(untrained.asked[0].recipe, untrained.asked[2].recipe);
  const dataset::Dataset &with_two = untrained.data.at("two-1").train,
                         &with_one = untrained.data.at("one-1").train;
  EXPECT_EQ(with_two.sensors.size(), 2U);
  EXPECT_EQ(with_one.sensors, (std::vector<std::string>{"mentalis"}));
  EXPECT_EQ(with_two.sequences.front().weights, with_one.sequences.front().weights);

  ASSERT_EQ(trained->size(), 2U);
  for (const TrainedPlacement& row : *trained)
    for (const measure::SeedFigures* figures :
         {&row.device.pve_mm, &row.device.mse, &row.lab.pve_mm, &row.lab.mse}) {
      ASSERT_EQ(figures->size(), 2U);
      for (const std::vector<double>& seed : *figures) EXPECT_EQ(seed.size(), 2U);
    }
  EXPECT_NE((*trained)[0].device.pve_mm[0], (*trained)[0].device.pve_mm[1]);
}

}  // namespace
}  // namespace mien::lab::placement_study_test
