#include "mien/tracker/window_solver.h"

#include <gmock/gmock.h>

#include <utility>

#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::tracker::window_solver_test {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

WindowSolver tiny_solver() {
  return WindowSolver::create(test::tiny_model(kSensors)).value();
}

std::vector<face::OutputFrame> solve(const std::vector<model::FeatureFrame>& features,
                                     const std::vector<std::string>& sensors = kSensors) {
  const WindowSolver solver = tiny_solver();
  return solver.solve(features, sensors, solver.file().sampler, no_progress).value();
}

std::vector<face::BlendshapeWeights> weights_of(const std::vector<face::OutputFrame>& frames) {
  std::vector<face::BlendshapeWeights> weights;
  for (const face::OutputFrame& frame : frames) weights.push_back(frame.weights);
  return weights;
}

TEST(WindowSolver, RefusesAModelOfOtherShapes) {
  model::ModelFile file = test::tiny_model(kSensors);
  std::swap(file.shapes[0], file.shapes[1]);
  const auto solver = WindowSolver::create(std::move(file));
  ASSERT_FALSE(solver);
  EXPECT_EQ(solver.error().code, ErrorCode::mismatch);
}

TEST(WindowSolver, RefusesANetworkThatLacksATensor) {
  model::ModelFile file = test::tiny_model(kSensors);
  file.network.pop_back();
  EXPECT_FALSE(WindowSolver::create(std::move(file)));
}

TEST(WindowSolver, GivesOneFrameAFrame) {
  // Shorter than a window, exactly one, and several with a last one that is moved back.
  for (const std::size_t count : {1U, 7U, 16U, 17U, 53U}) {
    const auto features = test::turning(count);
    const auto frames = solve(features);
    ASSERT_EQ(frames.size(), count);
    for (std::size_t f = 0; f < count; ++f) {
      EXPECT_EQ(frames[f].time, features[f].time);
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        EXPECT_GE(frames[f].weights[k], 0);
        EXPECT_LE(frames[f].weights[k], 1);
        EXPECT_EQ(frames[f].confidence[k], 1);
      }
      EXPECT_EQ(frames[f].provenance, test::felt());
      EXPECT_EQ(frames[f].head_provenance, face::Provenance::neutral);
      EXPECT_EQ(frames[f].head_confidence, 0);
    }
  }
}

TEST(WindowSolver, AnswersTheSameAgainAndToOtherInputOtherwise) {
  const auto one = weights_of(solve(test::turning(40)));
  EXPECT_EQ(one, weights_of(solve(test::turning(40))));
  auto features = test::turning(40);
  features[20].sensors[1].rotation = {0.8F, 0.6F, 0, 0};
  EXPECT_NE(one, weights_of(solve(features)));
}

TEST(WindowSolver, FindsSensorsByNameNotByPlace) {
  auto features = test::turning(40, 3);
  const auto inner = test::turning(40);
  for (std::size_t f = 0; f < features.size(); ++f)
    features[f].sensors = {inner[f].sensors[1], features[f].sensors[2], inner[f].sensors[0]};
  EXPECT_EQ(weights_of(solve(inner)),
            weights_of(solve(features, {"buccinator_L", "frontalis_R", "mentalis"})));
}

TEST(WindowSolver, ASensorThatTheRigLacksIsMissing) {
  const auto features = test::turning(40);
  auto absent = features;
  auto lacking = features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    absent[f].sensors[1] = {};
    lacking[f].sensors.resize(1);
  }
  const auto frames = solve(lacking, {"mentalis"});
  EXPECT_EQ(weights_of(frames), weights_of(solve(absent)));
  EXPECT_NE(weights_of(frames), weights_of(solve(features)));
  EXPECT_EQ(frames[5].confidence[0], 1) << "the ridge reads the other alone";
  EXPECT_EQ(frames[5].provenance[0], face::Provenance::measured);
}

TEST(WindowSolver, SaysWhenItSawNothing) {
  auto features = test::turning(10);
  for (model::SensorFeature& sensor : features[4].sensors) sensor = {};
  const auto frames = solve(features);
  EXPECT_EQ(frames[4].confidence[30], 0);
  EXPECT_EQ(frames[4].provenance[30], face::Provenance::predicted);
  EXPECT_EQ(frames[5].provenance[30], face::Provenance::measured);
}

TEST(WindowSolver, PassesTheHeadOn) {
  auto features = test::turning(10);
  features[3].head = exp_rotation(Vec3(0, 0.3, 0));
  features[3].has_head = true;
  const auto frames = solve(features);
  EXPECT_EQ(frames[3].head.coeffs(), features[3].head.coeffs());
  EXPECT_EQ(frames[3].head_provenance, face::Provenance::measured);
  EXPECT_EQ(frames[3].head_confidence, 1);
  EXPECT_EQ(frames[4].head_provenance, face::Provenance::neutral);
}

TEST(WindowSolver, RefusesARigWithoutAnyOfItsSensors) {
  const WindowSolver solver = tiny_solver();
  const auto frames =
      solver.solve(test::turning(10), {"frontalis_L", "frontalis_R"}, solver.file().sampler, no_progress);
  ASSERT_FALSE(frames);
  EXPECT_EQ(frames.error().code, ErrorCode::mismatch);
  EXPECT_THAT(frames.error().message(), HasSubstr("none of the model's sensors"));
}

TEST(WindowSolver, RefusesWhatCannotBeSolved) {
  const WindowSolver solver = tiny_solver();
  EXPECT_FALSE(solver.solve({}, kSensors, solver.file().sampler, no_progress));
  model::SamplerSettings settings = solver.file().sampler;
  settings.steps = 100'000;
  EXPECT_FALSE(solver.solve(test::turning(10), kSensors, settings, no_progress));
}

TEST(WindowSolver, StopsWhenAsked) {
  const WindowSolver solver = tiny_solver();
  const auto frames = solver.solve(test::turning(200), kSensors, solver.file().sampler,
                                   [](double fraction, std::string_view) { return fraction < 0.3; });
  ASSERT_FALSE(frames);
  EXPECT_EQ(frames.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::tracker::window_solver_test
