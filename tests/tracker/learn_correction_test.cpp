#include "mien/tracker/learn_correction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mien/core/random.h"
#include "mien/model/schedule.h"
#include "mien/tracker/causal_tracker.h"
#include "mien/tracker/model_input.h"
#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::tracker::learn_correction_test {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

/// A face of three vertices; the jaw moves one, a smile another.
face::Face small_face() {
  face::Face face;
  face.neutral_m.assign(3, Vec3f::Zero());
  for (const std::string_view name : face::kShapeNames) face.shapes.push_back({std::string(name), {}, {}});
  face.shapes[face::shape("jawOpen")].vertex = {0};
  face.shapes[face::shape("jawOpen")].delta_m = {Vec3f(0, -0.02F, 0)};
  face.shapes[face::shape("mouthSmile_L")].vertex = {1};
  face.shapes[face::shape("mouthSmile_L")].delta_m = {Vec3f(0.01F, 0, 0)};
  return face;
}

std::vector<face::BlendshapeWeights> answers_of(const model::ModelFile& file,
                                                const std::vector<model::FeatureFrame>& features) {
  CausalTracker tracker = CausalTracker::create(file, kSensors).value();
  std::vector<face::BlendshapeWeights> answers;
  face::OutputFrame frame;
  for (const model::FeatureFrame& feature : features) {
    tracker.step(feature, frame);
    answers.push_back(frame.weights);
  }
  return answers;
}

/// The same before the jitter filter.
std::vector<face::BlendshapeWeights> unfiltered(const model::ModelFile& file,
                                                const std::vector<model::FeatureFrame>& features) {
  const CausalTracker tracker = CausalTracker::create(file, kSensors).value();
  ModelInput input(file, kSensors);
  model::CausalNetwork::State state(tracker.network());
  std::vector<float> condition(file.features.width()), answer(face::kShapeCount);
  std::vector<face::BlendshapeWeights> answers;
  for (const model::FeatureFrame& feature : features) {
    input.encode(feature, condition);
    tracker.network().step(condition, state, answer);
    std::ranges::transform(answer, answers.emplace_back().values.begin(), model::from_network);
  }
  return answers;
}

double error_of(const std::vector<face::BlendshapeWeights>& answers, const std::vector<TaughtFrame>& taught) {
  double sum = 0;
  for (std::size_t f = 0; f < answers.size(); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      sum += std::pow(double{answers[f][k]} - double{taught[f].weights[k]}, 2);
  return sum;
}

/// Somebody in whom every shape is half of what the model says.
std::vector<TaughtFrame> halves(const std::vector<face::BlendshapeWeights>& answers) {
  std::vector<TaughtFrame> taught;
  for (const face::BlendshapeWeights& answer : answers) {
    TaughtFrame& frame = taught.emplace_back(TaughtFrame{.known = true, .weights = {}});
    for (std::size_t k = 0; k < face::kShapeCount; ++k) frame.weights[k] = 0.5F * answer[k];
  }
  return taught;
}

TEST(LearnCorrection, LearnsWhatAWearerDoesOtherwise) {
  const auto features = test::turning(1'500);
  model::ModelFile file = test::tiny_causal_model(kSensors);
  const auto answers = answers_of(file, features);
  std::vector<TaughtFrame> taught = halves(answers);
  // What is not known is not learnt from, whatever stands there.
  for (std::size_t f = 300; f < 500; ++f) taught[f] = {.known = false, .weights = {}};
  const auto learnt = learn_correction(features, taught, kSensors, small_face(), file);
  ASSERT_TRUE(learnt) << learnt.error().message();
  EXPECT_TRUE(learnt->taken);
  EXPECT_EQ(learnt->frames, 1'300U);
  EXPECT_GT(learnt->shapes, 20U);
  EXPECT_LT(learnt->mse_after, 0.2 * learnt->mse_before);
  EXPECT_LT(learnt->skin_after_mm, learnt->skin_before_mm);
  ASSERT_TRUE(file.correction);
  EXPECT_LT(error_of(answers_of(file, features), halves(answers)), 0.2 * error_of(answers, halves(answers)));

  // Learnt anew from the bare model, not on top of itself.
  model::ModelFile again = file;
  ASSERT_TRUE(learn_correction(features, taught, kSensors, small_face(), again));
  EXPECT_EQ(again.correction, file.correction);
  // A wearer's skin is not learnt under it.
  EXPECT_EQ(CausalTracker::create(file, kSensors)->personal(), nullptr);
}

TEST(LearnCorrection, KeepsTheModelWhereNothingIsForetoldBetter) {
  const auto features = test::turning(1'200);
  model::ModelFile file = test::tiny_causal_model(kSensors);
  std::vector<TaughtFrame> taught = halves(answers_of(file, features));
  const auto answers = unfiltered(file, features);
  for (std::size_t f = 0; f < taught.size(); ++f) taught[f].weights = answers[f];
  const auto learnt = learn_correction(features, taught, kSensors, small_face(), file);
  ASSERT_TRUE(learnt) << learnt.error().message();
  EXPECT_FALSE(learnt->taken);
  EXPECT_FALSE(file.correction);
}

TEST(LearnCorrection, SaysWhatItMisses) {
  const auto features = test::turning(900);
  model::ModelFile file = test::tiny_causal_model(kSensors);
  std::vector<TaughtFrame> taught(900);
  for (std::size_t f = 0; f < 500; ++f) taught[f].known = true;
  auto refused = learn_correction(features, taught, kSensors, small_face(), file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::not_found);
  EXPECT_THAT(refused.error().message(), HasSubstr("8.3 s"));
  model::ModelFile window = test::tiny_model(kSensors);
  refused = learn_correction(features, taught, kSensors, small_face(), window);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
  taught.assign(900, TaughtFrame{.known = true, .weights = {}});
  refused = learn_correction(features, taught, kSensors, small_face(), file,
                             [](double, std::string_view) { return false; });
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::tracker::learn_correction_test
