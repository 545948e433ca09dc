#include "mien/tracker/wearer_learner.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mien/tracker/personalise.h"
#include "mien/tracker/tracker.h"
#include "tests/tracker/prompted_minute.h"

namespace mien::tracker::wearer_learner_test {
namespace {

using test::kNames;
using test::Minute;

struct Answer {
  DeviceTime at;
  WearerLearner::Learnt learnt;
};

/// The minute as a session goes on, and twenty seconds more; what was learnt, and when.
std::vector<Answer> go_through(WearerLearner& learner, const Minute& minute, const model::ModelFile& file) {
  std::vector<Answer> answers;
  const auto add = [&](const model::FeatureFrame& frame) {
    if (auto learnt = learner.add(frame, file)) answers.push_back({frame.time, *std::move(learnt)});
  };
  for (const model::FeatureFrame& frame : minute.features) add(frame);
  model::FeatureFrame after = minute.features.back();
  const DeviceTime end = minute.prompts.back().end;
  for (int f = 0; f < 1200; ++f) {
    after.time = end + from_seconds(f / 60.0);
    add(after);
  }
  return answers;
}

TEST(WearerLearner, HandsOutWhatWasLearntOnceAndAtAKnownFrame) {
  const Minute minute(1);
  const model::ModelFile file = minute.model();
  WearerLearner learner(kNames);
  EXPECT_TRUE(go_through(learner, minute, file).empty()) << "nothing was asked for";
  for (const PromptedExpression& asked : minute.prompts) learner.expect(asked);
  const std::vector<Answer> answers = go_through(learner, minute, file);
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].at, minute.prompts.back().end + kWearerLearnt);
  const WearerLearner::Learnt& learnt = answers[0].learnt;
  EXPECT_TRUE(learnt.score.pass) << learnt.score.sentence;
  EXPECT_GT(learnt.score.value, 0);
  EXPECT_LT(minute.left(learnt.slopes), 0.8);
  for (const float slope : learnt.slopes)
    ASSERT_EQ(slope, static_cast<float>(std::round(1e6 * slope) / 1e6)) << "as a calibration's JSON has it";

  for (const PromptedExpression& asked : minute.prompts) learner.expect(asked);
  const std::vector<Answer> again = go_through(learner, minute, file);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].learnt.slopes, learnt.slopes);
}

TEST(WearerLearner, AWearerOfTheStandardSkinGetsThat) {
  // The first time each shape is asked for somebody else answers, so nothing is foretold better.
  const Minute other(5, 1.5);
  Minute minute(3, 0);
  for (std::size_t f = minute.features.size() / 2; f < minute.features.size(); ++f)
    minute.features[f] = other.features[f];
  const model::ModelFile file = minute.model();
  WearerLearner learner(kNames);
  for (const PromptedExpression& asked : minute.prompts) learner.expect(asked);
  const std::vector<Answer> answers = go_through(learner, minute, file);
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_TRUE(answers[0].learnt.score.pass);
  EXPECT_EQ(answers[0].learnt.score.value, 0);
  ASSERT_EQ(answers[0].learnt.slopes.size(), file.skin->standard.size());
  for (std::size_t i = 0; i < file.skin->standard.size(); ++i)
    ASSERT_NEAR(answers[0].learnt.slopes[i], file.skin->standard[i], 1e-6);
}

TEST(WearerLearner, WhatIsCancelledIsNotHandedOut) {
  const Minute minute(1);
  const model::ModelFile file = minute.model();
  WearerLearner learner(kNames);
  for (const PromptedExpression& asked : minute.prompts) learner.expect(asked);
  const DeviceTime end = minute.prompts.back().end;
  for (model::FeatureFrame frame : minute.features) ASSERT_FALSE(learner.add(frame, file));
  model::FeatureFrame after = minute.features.back();
  after.time = end + std::chrono::seconds(1);
  EXPECT_FALSE(learner.add(after, file)) << "now it learns";
  learner.cancel();
  after.time = end + kWearerLearnt + std::chrono::seconds(1);
  EXPECT_FALSE(learner.add(after, file));
}

TEST(WearerLearner, SaysWhyNothingCouldBeLearnt) {
  Minute minute(1);
  for (model::FeatureFrame& frame : minute.features)
    for (model::SensorFeature& sensor : frame.sensors) sensor.has_rotation = false;
  WearerLearner learner(kNames);
  for (const PromptedExpression& asked : minute.prompts) learner.expect(asked);
  const std::vector<Answer> answers = go_through(learner, minute, minute.model());
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_FALSE(answers[0].learnt.score.pass);
  EXPECT_TRUE(answers[0].learnt.slopes.empty());
  EXPECT_NE(answers[0].learnt.score.sentence.find("too few expressions were measured"), std::string::npos)
      << answers[0].learnt.score.sentence;
}

}  // namespace
}  // namespace mien::tracker::wearer_learner_test
