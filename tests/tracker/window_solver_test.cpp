#include "mien/tracker/window_solver.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <utility>

#include "tests/tracker/tiny_model.h"

namespace mien::tracker {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

WindowSolver tiny_solver() {
  return WindowSolver::create(test::tiny_model(kSensors)).value();
}

/// Frames of sensors that turn about X, each in its own way.
std::vector<model::FeatureFrame> turning(std::size_t frames, std::size_t sensors = 2) {
  std::vector<model::FeatureFrame> out(frames);
  for (std::size_t f = 0; f < frames; ++f) {
    out[f].time = DeviceTime(frame_offset(static_cast<std::int64_t>(f) + 600));
    out[f].sensors.resize(sensors);
    for (std::size_t s = 0; s < sensors; ++s) {
      const double half = 0.1 * std::sin(0.2 * static_cast<double>(f) + static_cast<double>(s));
      out[f].sensors[s].rotation = {static_cast<float>(std::cos(half)), static_cast<float>(std::sin(half)), 0,
                                    0};
      out[f].sensors[s].has_rotation = true;
    }
  }
  return out;
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
    const auto features = turning(count);
    const auto frames = solve(features);
    ASSERT_EQ(frames.size(), count);
    for (std::size_t f = 0; f < count; ++f) {
      EXPECT_EQ(frames[f].time, features[f].time);
      for (std::size_t k = 0; k < face::kShapeCount; ++k) {
        EXPECT_GE(frames[f].weights[k], 0);
        EXPECT_LE(frames[f].weights[k], 1);
        EXPECT_EQ(frames[f].confidence[k], 1);
        EXPECT_EQ(frames[f].provenance[k], face::Provenance::measured);
      }
      EXPECT_EQ(frames[f].head_provenance, face::Provenance::neutral);
      EXPECT_EQ(frames[f].head_confidence, 0);
    }
  }
}

TEST(WindowSolver, AnswersTheSameAgainAndToOtherInputOtherwise) {
  const auto one = weights_of(solve(turning(40)));
  EXPECT_EQ(one, weights_of(solve(turning(40))));
  auto features = turning(40);
  features[20].sensors[1].rotation = {0.8F, 0.6F, 0, 0};
  EXPECT_NE(one, weights_of(solve(features)));
}

TEST(WindowSolver, FindsSensorsByNameNotByPlace) {
  auto features = turning(40, 3);
  const auto inner = turning(40);
  for (std::size_t f = 0; f < features.size(); ++f)
    features[f].sensors = {inner[f].sensors[1], features[f].sensors[2], inner[f].sensors[0]};
  EXPECT_EQ(weights_of(solve(inner)),
            weights_of(solve(features, {"buccinator_L", "frontalis_R", "mentalis"})));
}

TEST(WindowSolver, ASensorThatTheRigLacksIsMissing) {
  const auto features = turning(40);
  auto absent = features;
  auto lacking = features;
  for (std::size_t f = 0; f < features.size(); ++f) {
    absent[f].sensors[1] = {};
    lacking[f].sensors.resize(1);
  }
  const auto frames = solve(lacking, {"mentalis"});
  EXPECT_EQ(weights_of(frames), weights_of(solve(absent)));
  EXPECT_NE(weights_of(frames), weights_of(solve(features)));
  EXPECT_EQ(frames[5].confidence[0], 0.5F);
  EXPECT_EQ(frames[5].provenance[0], face::Provenance::measured);
}

TEST(WindowSolver, SaysWhenItSawNothing) {
  auto features = turning(10);
  for (model::SensorFeature& sensor : features[4].sensors) sensor = {};
  const auto frames = solve(features);
  EXPECT_EQ(frames[4].confidence[30], 0);
  EXPECT_EQ(frames[4].provenance[30], face::Provenance::predicted);
  EXPECT_EQ(frames[5].provenance[30], face::Provenance::measured);
}

TEST(WindowSolver, PassesTheHeadOn) {
  auto features = turning(10);
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
      solver.solve(turning(10), {"frontalis_L", "frontalis_R"}, solver.file().sampler, no_progress);
  ASSERT_FALSE(frames);
  EXPECT_EQ(frames.error().code, ErrorCode::mismatch);
  EXPECT_THAT(frames.error().message(), HasSubstr("none of the model's sensors"));
}

TEST(WindowSolver, RefusesWhatCannotBeSolved) {
  const WindowSolver solver = tiny_solver();
  EXPECT_FALSE(solver.solve({}, kSensors, solver.file().sampler, no_progress));
  auto features = turning(10);
  features[2].sensors[0].rotation[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(solver.solve(features, kSensors, solver.file().sampler, no_progress).error().code,
            ErrorCode::out_of_range);
  model::SamplerSettings settings = solver.file().sampler;
  settings.steps = 100'000;
  EXPECT_FALSE(solver.solve(turning(10), kSensors, settings, no_progress));
}

TEST(WindowSolver, StopsWhenAsked) {
  const WindowSolver solver = tiny_solver();
  const auto frames = solver.solve(turning(200), kSensors, solver.file().sampler,
                                   [](double fraction, std::string_view) { return fraction < 0.3; });
  ASSERT_FALSE(frames);
  EXPECT_EQ(frames.error().code, ErrorCode::cancelled);
}

TEST(WindowSolver, RidgeIsThatOfTheProfile) {
  const WindowSolver solver = tiny_solver();
  const auto features = turning(10);
  const auto lab = solver.ridge(features, kSensors, "lab");
  const auto device = solver.ridge(features, kSensors, "device");
  ASSERT_EQ(lab.size(), 10U);
  ASSERT_EQ(device.size(), 10U);
  for (std::size_t f = 0; f < 10; ++f) {
    // tiny_model(): half of the first sensor's x, which is normalised by 0.5, and the profile's constant.
    const float x = features[f].sensors[0].rotation[1];
    EXPECT_NEAR(lab[f][7], std::max(0.0F, 0.25F + x), 1e-6);
    EXPECT_NEAR(device[f][7], 0.5F + x, 1e-6);
  }
  EXPECT_TRUE(solver.ridge(features, kSensors, "cinema").empty());
}

}  // namespace
}  // namespace mien::tracker
