#include "mien/tracker/causal_tracker.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "mien/core/random.h"
#include "mien/model/network_correction.h"
#include "tests/allocation_count.h"
#include "tests/tracker/tiny_model.h"
#include "tests/tracker/turning_sensors.h"

namespace mien::tracker::causal_tracker_test {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

CausalTracker tiny_tracker(const std::vector<std::string>& rig = kSensors) {
  return CausalTracker::create(test::tiny_causal_model(kSensors), rig).value();
}

std::vector<face::OutputFrame> run(CausalTracker& tracker, const std::vector<model::FeatureFrame>& features) {
  std::vector<face::OutputFrame> out(features.size());
  for (std::size_t f = 0; f < features.size(); ++f) tracker.step(features[f], out[f]);
  return out;
}
std::vector<face::OutputFrame> run(const std::vector<model::FeatureFrame>& features,
                                   const std::vector<std::string>& rig = kSensors) {
  CausalTracker tracker = tiny_tracker(rig);
  return run(tracker, features);
}

std::vector<face::BlendshapeWeights> weights_of(const std::vector<face::OutputFrame>& frames) {
  std::vector<face::BlendshapeWeights> weights;
  for (const face::OutputFrame& frame : frames) weights.push_back(frame.weights);
  return weights;
}

TEST(CausalTracker, FillsAFrameAFrame) {
  const auto features = test::turning(50);
  const auto frames = run(features);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    EXPECT_EQ(frames[f].time, features[f].time);
    for (const float w : frames[f].weights.values) {
      EXPECT_GE(w, 0);
      EXPECT_LE(w, 1);
    }
    EXPECT_THAT(frames[f].confidence, Each(1));
    EXPECT_EQ(frames[f].provenance, test::felt());
    EXPECT_EQ(frames[f].head_provenance, face::Provenance::neutral);
    EXPECT_EQ(frames[f].eyes_provenance, face::Provenance::neutral);
  }
}

TEST(CausalTracker, NothingIsLeftOfTheFrameBefore) {
  auto features = test::turning(2);
  features[0].head = exp_rotation(Vec3(0, 0.3, 0));
  features[0].has_head = true;
  CausalTracker tracker = tiny_tracker();
  face::OutputFrame frame;
  tracker.step(features[0], frame);
  EXPECT_EQ(frame.head.coeffs(), features[0].head.coeffs());
  EXPECT_EQ(frame.head_provenance, face::Provenance::measured);
  EXPECT_EQ(frame.head_confidence, 1);
  tracker.step(features[1], frame);
  EXPECT_EQ(frame.head_provenance, face::Provenance::neutral);
  EXPECT_EQ(frame.head_confidence, 0);
}

TEST(CausalTracker, WhatComesLaterChangesNothing) {
  auto features = test::turning(40);
  const auto once = weights_of(run(features));
  features[20].sensors[1].rotation = {0.8F, 0.6F, 0, 0};
  const auto changed = weights_of(run(features));
  for (std::size_t f = 0; f < 20; ++f) EXPECT_EQ(once[f], changed[f]);
  EXPECT_NE(once, changed);
}

TEST(CausalTracker, AResetBeginsAnew) {
  const auto features = test::turning(40);
  CausalTracker tracker = tiny_tracker();
  const auto once = weights_of(run(tracker, features));
  EXPECT_NE(weights_of(run(tracker, features)), once);
  tracker.reset();
  EXPECT_EQ(weights_of(run(tracker, features)), once);
  CausalTracker moved = std::move(tracker);
  moved.reset();
  EXPECT_EQ(weights_of(run(moved, features)), once);
}

TEST(CausalTracker, AllocatesNothing) {
  const auto features = test::turning(40);
  CausalTracker tracker = tiny_tracker();
  face::OutputFrame frame;
  const std::size_t before = mien::test::allocation_count();
  for (const model::FeatureFrame& f : features) tracker.step(f, frame);
  tracker.reset();
  EXPECT_EQ(mien::test::allocation_count(), before);
}

/// A model of eleven sensors that is some wearer's.
model::ModelFile worn_model(const std::vector<std::string>& sensors) {
  model::ModelFile file = test::tiny_causal_model(sensors);
  Random random(4);
  model::Skin& skin = file.skin.emplace();
  for (std::size_t i = 0; i < 3 * sensors.size() * face::kShapeCount; ++i) {
    skin.standard.push_back(static_cast<float>(0.1 * random.normal()));
    skin.wearer.push_back(skin.standard.back() * static_cast<float>(1 + 0.3 * random.normal()));
  }
  skin.covariance.assign(face::kShapeCount * face::kShapeCount, 0.0F);
  for (std::size_t k = 0; k < face::kShapeCount; ++k) skin.covariance[k * face::kShapeCount + k] = 0.02F;
  return file;
}

TEST(CausalTracker, AWearersSkinTakesNoMemoryAndRepeatsItsBits) {
  std::vector<std::string> sensors;
  for (int s = 0; s < 11; ++s) sensors.push_back("sensor " + std::to_string(s));
  auto features = test::turning(60, sensors.size());
  // Sensors come and go.
  for (std::size_t f = 10; f < 40; ++f) features[f].sensors[f % 11] = {};
  CausalTracker tracker = CausalTracker::create(worn_model(sensors), sensors).value();
  face::OutputFrame frame;
  const std::size_t before = mien::test::allocation_count();
  for (const model::FeatureFrame& f : features) tracker.step(f, frame);
  EXPECT_EQ(mien::test::allocation_count(), before);
  tracker.reset();
  const auto once = weights_of(run(tracker, features));
  tracker.reset();
  EXPECT_EQ(weights_of(run(tracker, features)), once);
  // It is not what everybody's model says.
  model::ModelFile anybody = worn_model(sensors);
  anybody.skin->wearer.clear();
  CausalTracker other = CausalTracker::create(std::move(anybody), sensors).value();
  EXPECT_NE(weights_of(run(other, features)), once);
}

TEST(CausalTracker, ConfidenceIsTheTablesForTheSensorsThatFeelAShape) {
  // The ridge of tiny_model() listens to the first sensor alone.
  auto features = test::turning(3);
  features[1].sensors[0] = {};
  features[2].sensors[1] = {};
  auto frames = run(features);
  EXPECT_THAT(frames[1].confidence, Each(0));
  EXPECT_THAT(frames[1].provenance, Each(face::Provenance::predicted));
  EXPECT_THAT(frames[2].confidence, Each(1));
  EXPECT_EQ(frames[2].provenance, test::felt());
  // Without a ridge all sensors count alike.
  model::ModelFile file = test::tiny_causal_model(kSensors);
  file.ridge.clear();
  CausalTracker alike = CausalTracker::create(std::move(file), kSensors).value();
  frames = run(alike, features);
  EXPECT_THAT(frames[1].confidence, Each(0.5F));
  EXPECT_THAT(frames[2].confidence, Each(0.5F));
  EXPECT_EQ(frames[1].provenance, test::felt());
}

TEST(CausalTracker, WithoutATableNothingIsMeasuredAndTheWeightsStay) {
  model::ModelFile file = test::tiny_causal_model(kSensors);
  file.confidence.reset();
  CausalTracker tracker = CausalTracker::create(std::move(file), kSensors).value();
  const auto features = test::turning(20);
  const auto frames = run(tracker, features);
  EXPECT_THAT(frames[10].provenance, Each(face::Provenance::predicted));
  EXPECT_THAT(frames[10].confidence, Each(0));
  EXPECT_EQ(weights_of(frames), weights_of(run(features)));
}

TEST(CausalTracker, ShapesAreToldApartByWhatIsExplainedOfEachAndByTheWeightShown) {
  model::ModelFile file = test::tiny_causal_model(kSensors);
  model::ConfidenceTable& table = *file.confidence;
  const std::size_t jaw = face::shape("jawOpen"), gaze = face::shape("eyeLookIn_R");
  table.value_edges = {0.3F};
  table.within.clear();
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    for (const float within : {0.1F, 0.05F, 0.6F, 0.4F, 0.9F, 0.7F}) table.within.push_back(within);
  for (std::size_t c = 0; c < table.coverage_bins(); ++c)
    table.explained[jaw * table.coverage_bins() + c] = 0.49F;
  CausalTracker tracker = CausalTracker::create(std::move(file), kSensors).value();
  for (const face::OutputFrame& frame : run(tracker, test::turning(60))) {
    EXPECT_EQ(frame.provenance[jaw], face::Provenance::predicted);
    EXPECT_EQ(frame.provenance[gaze], face::Provenance::predicted) << "all of it explained, and no eye seen";
    EXPECT_EQ(frame.provenance[face::shape("mouthPucker")], face::Provenance::measured);
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      EXPECT_EQ(frame.confidence[k], frame.weights[k] >= 0.3F ? 0.7F : 0.9F);
  }
}

TEST(CausalTracker, SaysWhenItFeltNothing) {
  auto features = test::turning(3);
  for (model::SensorFeature& sensor : features[1].sensors) sensor = {};
  const auto frames = run(features);
  EXPECT_THAT(frames[1].confidence, Each(0));
  EXPECT_THAT(frames[1].provenance, Each(face::Provenance::predicted));
  EXPECT_EQ(frames[2].provenance, test::felt());
}

TEST(CausalTracker, AReadingThatIsNotFiniteIsMissingAndSpoilsNothing) {
  auto features = test::turning(20), missing = features;
  features[5].sensors[0].rotation[1] = std::numeric_limits<float>::quiet_NaN();
  missing[5].sensors[0] = {};
  EXPECT_EQ(weights_of(run(features)), weights_of(run(missing)));
}

TEST(CausalTracker, RefusesWhatItCannotRun) {
  const auto code = [](model::ModelFile file, const std::vector<std::string>& rig = kSensors) {
    return CausalTracker::create(std::move(file), rig).error().code;
  };
  EXPECT_EQ(code(test::tiny_causal_model(kSensors), {"frontalis_R"}), ErrorCode::mismatch);
  EXPECT_EQ(code(test::tiny_causal_model(kSensors), {}), ErrorCode::mismatch);
  EXPECT_EQ(code(test::tiny_model(kSensors)), ErrorCode::mismatch) << "a window network";
  model::ModelFile file = test::tiny_causal_model(kSensors);
  std::swap(file.shapes[0], file.shapes[1]);
  EXPECT_EQ(code(file), ErrorCode::mismatch);
  file = test::tiny_causal_model(kSensors);
  file.network.pop_back();
  EXPECT_EQ(code(file), ErrorCode::mismatch);
  const auto refused = CausalTracker::create(test::tiny_model(kSensors), kSensors);
  EXPECT_THAT(refused.error().message(), HasSubstr("live.safetensors"));
}

TEST(CausalTracker, ACorrectionIsPutInForceAndTakenBackWhileItRuns) {
  const auto features = test::turning(400);
  CausalTracker plain = tiny_tracker(), corrected = tiny_tracker();
  const model::Architecture& network = plain.file().architecture;
  constexpr std::size_t kJaw = face::shape("jawOpen");
  // The jaw is wide open, whatever is seen; all else is as it was.
  model::Correction opens{.network = model::correction_key(plain.file().network),
                          .weights = std::vector<float>(network.outputs * network.d_model),
                          .bias = std::vector<float>(network.outputs)};
  opens.bias[kJaw] = 4;
  ASSERT_TRUE(plain.check_correction(opens));
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (f == 10) corrected.use_correction(&opens);
    if (f == 200) corrected.use_correction(nullptr);
    face::OutputFrame as_it_is, as_corrected;
    plain.step(features[f], as_it_is);
    corrected.step(features[f], as_corrected);
    if (f < 10) {
      ASSERT_EQ(as_corrected.weights, as_it_is.weights) << f;
    }
    if (f == 100) {
      // The filter's width follows all shapes together, so that the others may differ by a little.
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        EXPECT_TRUE(k == kJaw || std::abs(as_corrected.weights[k] - as_it_is.weights[k]) < 0.05F) << k;
    }
    if (f == 199) {
      EXPECT_GT(as_corrected.weights[kJaw], 0.99F);
    }
  }
  face::OutputFrame as_it_is, as_corrected;
  plain.step(features[0], as_it_is);
  corrected.step(features[0], as_corrected);
  EXPECT_NEAR(as_corrected.weights[kJaw], as_it_is.weights[kJaw], 1e-3F) << "the jitter filter has forgotten";
}

TEST(CausalTracker, ACorrectionOfAnotherNetworkIsRefused) {
  const CausalTracker tracker = tiny_tracker();
  const model::Architecture& network = tracker.file().architecture;
  const model::Correction own{.network = model::correction_key(tracker.file().network),
                              .weights = std::vector<float>(network.outputs * network.d_model),
                              .bias = std::vector<float>(network.outputs)};
  EXPECT_TRUE(tracker.check_correction(own));
  const auto code_of = [&](auto spoil) {
    model::Correction spoilt = own;
    spoil(spoilt);
    const auto checked = tracker.check_correction(spoilt);
    return checked ? std::optional<ErrorCode>() : checked.error().code;
  };
  EXPECT_EQ(code_of([](auto& c) { c.network = "0123456789abcdef"; }), ErrorCode::mismatch);
  EXPECT_EQ(code_of([](auto& c) { c.weights.pop_back(); }), ErrorCode::mismatch);
  EXPECT_EQ(code_of([](auto& c) { c.bias.push_back(0); }), ErrorCode::mismatch);
  EXPECT_EQ(code_of([](auto& c) { c.bias[0] = 11; }), ErrorCode::out_of_range);
  EXPECT_EQ(code_of([](auto& c) { c.weights[0] = std::nanf(""); }), ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::tracker::causal_tracker_test
