#include "mien/measure/evaluation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mien/builtin_face/builtin_face.h"

namespace mien::measure::evaluation_test {
namespace {

/// `frames` of a jaw that opens steadily; the first `easing` are not evaluated, and the face is lost at
/// `lost`.
std::vector<take::TruthFrame> opening(std::size_t frames, std::size_t easing, std::size_t lost) {
  std::vector<take::TruthFrame> truth(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    truth[i].weights[face::shape("jawOpen")] = static_cast<float>(i) / static_cast<float>(frames);
    truth[i].evaluated = i >= easing;
    truth[i].has_face = i != lost;
  }
  return truth;
}

TEST(HoldLast, IsTheTruthOfASecondAgoOrTheLastOneSeen) {
  const auto truth = opening(200, 0, 70);
  const auto held = hold_last(truth);
  ASSERT_EQ(held.size(), 200U);
  EXPECT_EQ(held[30], truth[0].weights) << "nothing is older";
  EXPECT_EQ(held[129], truth[69].weights);
  EXPECT_EQ(held[130], truth[69].weights) << "lost a second ago";
  EXPECT_EQ(held[131], truth[71].weights);
}

TEST(MeasureTrack, IsWhatEvaluateMakesOfOneTake) {
  const Meter meter(builtin_face::make_builtin());
  TakeEstimates take{.take = "one", .truth = opening(120, 10, 60), .model = {}, .ridge = {}};
  for (const take::TruthFrame& frame : take.truth) {
    take.model.push_back(frame.weights);
    take.model.back()[face::shape("mouthSmile_L")] += 0.2F;
  }
  const auto whole = evaluate(meter, {take}, {});
  ASSERT_TRUE(whole);
  const Metrics one = measure_track(meter, take.truth, take.model);
  EXPECT_EQ(one.frames, 109U);
  EXPECT_EQ(one.mse, whole->model.mse);
  EXPECT_EQ(one.pve_mm.mean, whole->model.pve_mm.mean);
  EXPECT_EQ(one.jitter_ratio, whole->model.jitter_ratio);
  EXPECT_EQ(measure_track(meter, take.truth, hold_last(take.truth)).mse, whole->hold_last.mse);
}

TEST(Evaluate, MotionIsMeasuredAboutEachShapesOwnRest) {
  const Meter meter(builtin_face::make_builtin());
  TakeEstimates take{.take = "one", .truth = opening(200, 10, 60), .model = {}, .ridge = {}};
  for (take::TruthFrame& frame : take.truth) {
    frame.weights[face::shape("jawOpen")] *= 0.5F;
    take.model.push_back(frame.weights);
    take.model.back()[face::shape("jawOpen")] += 0.2F;
  }
  const auto evaluation = evaluate(meter, {take}, {});
  ASSERT_TRUE(evaluation);
  EXPECT_NEAR(evaluation->model.mse, 0.2 * 0.2 / face::kShapeCount, 1e-6);
  ASSERT_TRUE(evaluation->model.about_rest);
  EXPECT_NEAR(evaluation->model.about_rest->mse, 0, 1e-9) << "it is off by a constant";
  EXPECT_NEAR(evaluation->model.about_rest->pve_mm, 0, 1e-4);
  EXPECT_GT(evaluation->mean_pose.about_rest.value().pve_mm, 0.1) << "a pose that does not move";
}

TEST(OverWears, GivesTheMeanAndItsInterval) {
  std::vector<Evaluation> evaluations(5);
  for (std::size_t i = 0; i < evaluations.size(); ++i) {
    evaluations[i].model.pve_mm.mean = 0.5 + 0.01 * static_cast<double>(i);
    evaluations[i].model.mse = 0.01;
    evaluations[i].model.about_rest = MotionErrors{.mse = 0.004, .pve_mm = 0.3};
  }
  const Wears wears = over_wears(evaluations);
  EXPECT_EQ(wears.count, 5U);
  EXPECT_NEAR(wears.pve_mm.mean, 0.52, 1e-12);
  EXPECT_NEAR(wears.pve_mm.half(), 2.7764 * std::sqrt(0.00025 / 5), 1e-6)
      << "Student's, 4 degrees of freedom";
  EXPECT_EQ(wears.mse.half(), 0);
  EXPECT_NEAR(wears.pve_about_rest_mm.mean, 0.3, 1e-12);
}

TEST(Evaluate, EyesThatTheModelTellsAreItsOwnAndNotTheBaselines) {
  const Meter meter(builtin_face::make_builtin());
  TakeEstimates take{.take = "one", .truth = opening(120, 10, 60), .model = {}, .ridge = {}};
  for (take::TruthFrame& frame : take.truth) {
    frame.weights[face::shape("eyeLookUp_L")] = frame.weights[face::shape("eyeLookUp_R")] = 0.5F;
    take.gaze_rad.push_back(face::eyes_rad(frame.weights));
  }
  take.model.resize(120);
  const auto evaluation = evaluate(meter, {take}, {});
  ASSERT_TRUE(evaluation);
  EXPECT_NEAR(evaluation->model.eyes_and_lips.value().gaze_deg.value().p90, 0, 1e-3);
  EXPECT_NEAR(evaluation->mean_pose.eyes_and_lips.value().gaze_deg.value().median, 17.5, 0.1);
}

TEST(Evaluate, MeasuresTheSameWithAStepLeftOut) {
  const Meter meter(builtin_face::make_builtin());
  TakeEstimates take{.take = "one", .truth = opening(120, 10, 60), .model = {}, .ridge = {}};
  for (const take::TruthFrame& frame : take.truth) take.model.push_back(frame.weights);
  std::vector<face::BlendshapeWeights> without = take.model;
  EXPECT_FALSE(measure_ablation(meter, {take}, "mend", std::array{without}).changed);
  without[0][face::shape("mouthSmile_L")] = 1;  // Not evaluated, but other bits.
  const Ablation unseen = measure_ablation(meter, {take}, "mend", std::array{without});
  EXPECT_TRUE(unseen.changed);
  EXPECT_EQ(unseen.metrics.mse, 0);
  for (auto& weights : without) weights[face::shape("mouthSmile_L")] += 0.53F;
  const Ablation worse = measure_ablation(meter, {take}, "smoothing", std::array{without});
  EXPECT_EQ(worse.without, "smoothing");
  EXPECT_NEAR(worse.metrics.mse, 0.53 * 0.53 / face::kShapeCount, 1e-6);
  EXPECT_EQ(worse.metrics.frames, 109U);
}

TEST(Evaluate, CountsHowShapesCameAboutInTheEvaluatedFrames) {
  const Meter meter(builtin_face::make_builtin());
  TakeEstimates take{.take = "one", .truth = opening(110, 10, 200), .model = {}, .ridge = {}};
  take.model.resize(110);
  EXPECT_FALSE(evaluate(meter, {take}, {})->provenance) << "nothing says it";
  take.provenance.resize(110);
  const std::size_t jaw = face::shape("jawOpen");
  for (std::size_t i = 0; i < 110; ++i) {
    take.provenance[i].fill(face::Provenance::predicted);
    if (i >= 35) take.provenance[i][jaw] = face::Provenance::measured;
  }
  const auto shares = evaluate(meter, {take}, {})->provenance;
  ASSERT_TRUE(shares);
  EXPECT_EQ((*shares)[jaw], (std::array{0.75, 0., 0.25, 0., 0., 0.}));
  EXPECT_EQ((*shares)[face::shape("eyeBlink_L")], (std::array{0., 0., 1., 0., 0., 0.}));
}

}  // namespace
}  // namespace mien::measure::evaluation_test
