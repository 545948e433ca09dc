#include "mien/measure/evaluation_report.h"

#include <gmock/gmock.h>

namespace mien::measure::evaluation_report_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Evaluation some_evaluation() {
  Evaluation evaluation;
  evaluation.frames = 5;
  evaluation.takes = 1;
  evaluation.model.frames = 5;
  evaluation.model.pve_mm = {0.75, 0.5};
  evaluation.model.lmk_mm = MeanStd{2.5, 2};
  evaluation.model.mse = 0.0625;
  evaluation.model.mse_curve = {0.1F, 0.2F, 0.3F, 0.2F, 0.1F};
  evaluation.model.pve_mm_curve = {1, 2, 3, 2, 1};
  evaluation.model.per_shape[face::shape("noseSneer_R")].mae = 0.9;
  evaluation.model.per_shape[face::shape("jawOpen")].mae = 0.5;
  evaluation.mean_pose.pve_mm_curve = {2, 2, 2, 2, 2};
  return evaluation;
}

EvaluationContext some_context() {
  return {.face = "<img src=x>", .model = "m.safetensors", .devices = "lab", .steps = 4};
}

TEST(EvaluationReport, SaysWhatWasMeasured) {
  const std::string html = evaluation_report(some_evaluation(), some_context()).html();
  EXPECT_THAT(html, HasSubstr("5 frames of 1 take on the face"));
  EXPECT_THAT(html, HasSubstr("4 denoising steps"));
  EXPECT_THAT(html, HasSubstr("0.750 mm"));
  EXPECT_THAT(html, HasSubstr("2.500 ± 2.000"));
  EXPECT_THAT(html, HasSubstr("0.0625"));
  EXPECT_THAT(html, HasSubstr("mean pose"));
  for (const std::string_view shape : face::kShapeNames) EXPECT_THAT(html, HasSubstr(std::string(shape)));
  // Worst first.
  EXPECT_LT(html.find("noseSneer_R"), html.find("jawOpen"));
  EXPECT_LT(html.find("jawOpen"), html.find("browDown_L"));
}

TEST(EvaluationReport, ShowsEyesAndLipsWhereTheyAreKnown) {
  Evaluation evaluation = some_evaluation();
  EXPECT_TRUE(eyes_and_lips_table(evaluation).rows.empty());
  EXPECT_THAT(evaluation_report(evaluation, some_context()).html(), Not(HasSubstr("Eyes, lids and lips")));
  evaluation.ece = 0.125;
  evaluation.model.eyes_and_lips = EyesAndLips{};
  evaluation.model.eyes_and_lips->gaze_deg = EyesAndLips::Angle{2.5, 7.5};
  const Table table = eyes_and_lips_table(evaluation);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"", "gaze median, °", "gaze p90, °", "ECE"}));
  EXPECT_EQ(table.rows.at(0), (std::vector<std::string>{"model", "2.5", "7.5", "0.125"}));
  EXPECT_THAT(evaluation_report(evaluation, some_context()).html(), HasSubstr("Eyes, lids and lips"));
  // The share of time with the eyes shut, where they ever are: the truth's first.
  evaluation.model.truth_shut = 0.0312;
  evaluation.blinking = Metrics{.shut = 0.04};
  const Table shutting = eyes_and_lips_table(evaluation);
  EXPECT_EQ(shutting.columns.at(3), "eyes shut, %");
  EXPECT_EQ(shutting.rows.at(0).front(), "truth");
  EXPECT_EQ(shutting.rows.at(0).at(3), "3.1");
  EXPECT_EQ(shutting.rows.at(2).at(3), "4.0");
}

TEST(EvaluationReport, NamesRidgeOnlyWhereThereIsOne) {
  Evaluation evaluation = some_evaluation();
  EXPECT_THAT(evaluation_report(evaluation, some_context()).html(), Not(HasSubstr("ridge, one frame")));
  evaluation.ridge = Metrics{};
  evaluation.ridge->pve_mm.mean = 1.5;
  const std::string html = evaluation_report(evaluation, some_context()).html();
  EXPECT_THAT(html, HasSubstr("ridge, one frame"));
  EXPECT_THAT(html, HasSubstr("0.50 of ridge"));
}

TEST(EvaluationReport, SaysNothingOfWhatIsNotThere) {
  Evaluation evaluation = some_evaluation();
  std::string html = evaluation_report(evaluation, some_context()).html();
  for (const char* absent :
       {"Ridge", "ridge", "blink F1", "Blink F1", "PVE face", "provenance", "Provenance"})
    EXPECT_THAT(html, Not(HasSubstr(absent)));
  evaluation.ridge = Metrics{};
  evaluation.hold_last.blink_f1 = 0;
  html = evaluation_report(evaluation, some_context()).html();
  for (const char* present : {"Ridge is linear", "ridge's error", "blink F1"})
    EXPECT_THAT(html, HasSubstr(present));
}

TEST(EvaluationReport, ShapesAreCalledWhatTheAnswerCalledThem) {
  Evaluation evaluation = some_evaluation();
  ProvenanceShares& shares = evaluation.provenance.emplace();
  for (auto& shape : shares) shape[static_cast<std::size_t>(face::Provenance::predicted)] = 1;
  shares[face::shape("jawOpen")] = {0.625, 0, 0, 0.25, 0, 0.125};
  const std::string html = evaluation_report(evaluation, some_context()).html();
  const auto cells_of = [&](const std::string& shape) {
    const std::size_t at = html.find(shape);
    return html.substr(at, html.find("</tr>", at) - at);
  };
  EXPECT_THAT(cells_of("jawOpen"), HasSubstr("measured 62 %, held 25 %, neutral 12 %"));
  for (const char* shape : {"eyeBlink_L", "jawLeft", "mouthFunnel", "eyeLookUp_L"})
    EXPECT_THAT(cells_of(shape), HasSubstr(">predicted<"));
  EXPECT_THAT(html, Not(HasSubstr("observed")));
}

TEST(EvaluationReport, BaselinesThatWinAreNamedBeforeAnyFigure) {
  Evaluation evaluation = some_evaluation();
  for (Metrics* baseline : {&evaluation.mean_pose, &evaluation.hold_last}) {
    baseline->pve_mm.mean = 2;
    baseline->mse = 1;
  }
  EXPECT_THAT(baselines_ahead(evaluation), ::testing::IsEmpty());
  evaluation.ridge = Metrics{};
  evaluation.ridge->pve_mm.mean = 0.5;
  evaluation.ridge->lmk_mm = MeanStd{3, 1};
  evaluation.ridge->mse = 0.03125;
  EXPECT_THAT(
      baselines_ahead(evaluation),
      ::testing::ElementsAre("Ridge is closer than the model here: PVE 0.500 against 0.750 mm, MSE 0.0312 "
                             "against 0.0625."));
  const std::string html = evaluation_report(evaluation, some_context()).html();
  EXPECT_LT(html.find("Ridge is closer"), html.find("Vertex error"));
}

TEST(EvaluationReport, NothingInANameIsMarkup) {
  EXPECT_THAT(evaluation_report(some_evaluation(), some_context()).html(), Not(HasSubstr("<img src=x>")));
}

TEST(EvaluationReport, AnEvaluationWithoutAnythingIsStillAPage) {
  EXPECT_THAT(evaluation_report(Evaluation{}, EvaluationContext{}).html(), HasSubstr("</html>"));
}

}  // namespace
}  // namespace mien::measure::evaluation_report_test
