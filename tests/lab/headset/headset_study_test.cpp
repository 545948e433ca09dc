#include "lab/headset/headset_study.h"

#include <gtest/gtest.h>

#include "mien/headset/answer.h"
#include "tests/headset/small_model.h"
#include "tests/project_path.h"

namespace mien::lab::headset_study_test {
namespace {

using Scores = std::vector<HeadsetScore>;

Result<Scores> study(unsigned threads) {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  static const auto model = headset::test::small_model_with_memory();
  HeadsetStudyRequest request;
  request.wearers = 2;
  request.seconds = 1;
  request.threads = threads;
  return study_headset(request, rig, model, std::vector<float>(headset::kAnswerOutputs, -1.0F), no_progress);
}

TEST(HeadsetStudy, MeasuresEveryConditionTheSameOnAnyNumberOfThreads) {
  const auto one = study(1), two = study(2);
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_TRUE(two) << two.error().message();
  ASSERT_EQ(one->size(), kHeadsetConditions);
  for (std::size_t c = 0; c < one->size(); ++c) {
    const HeadsetScore &a = (*one)[c], &b = (*two)[c];
    EXPECT_EQ(a.condition, static_cast<HeadsetCondition>(c));
    EXPECT_EQ(a.mse, b.mse);
    EXPECT_EQ(a.gaze_median_deg, b.gaze_median_deg);
    EXPECT_GT(a.mse, 0);
    EXPECT_GT(a.mean_pose_mse, 0);
    EXPECT_GT(a.pve_mm, 0);
    EXPECT_FALSE(condition_name(a.condition).empty());
  }
  // A network that has learnt nothing answers otherwise all the same when it sees less, or knows no rest.
  const HeadsetScore& worn = one->front();
  for (const HeadsetCondition other : {HeadsetCondition::no_neutral, HeadsetCondition::put_on_anew,
                                       HeadsetCondition::slow, HeadsetCondition::eye_lost})
    EXPECT_NE((*one)[static_cast<std::size_t>(other)].mse, worn.mse) << condition_name(other);
}

TEST(HeadsetStudy, RefusesNobody) {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  EXPECT_FALSE(study_headset({.wearers = 0}, rig, headset::test::small_model(), {}, no_progress));
}

Result<std::vector<std::vector<HeadsetHoursPiece>>> study(const HeadsetHoursRequest& request) {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/headset.toml")).value();
  static const auto model = headset::test::small_model_with_memory();
  return study_headset_hours(request, rig, model, std::vector<float>(headset::kAnswerOutputs, -1.0F),
                             no_progress);
}

TEST(HeadsetHours, AHeadsetThatSlipsIsSeenOtherwise) {
  const auto wearers = study({.wearers = 1, .minutes = 20, .seconds = 1});
  ASSERT_TRUE(wearers) << wearers.error().message();
  ASSERT_EQ(wearers->size(), 1U);
  ASSERT_EQ(wearers->front().size(), 2U);
  const HeadsetHoursPiece &first = wearers->front()[0], &second = wearers->front()[1];
  EXPECT_EQ(second.begin_s, 600);
  EXPECT_EQ(first.ratio, 1);
  EXPECT_EQ(first.worst_bias, 0);
  EXPECT_GT(second.mse, 0);
  EXPECT_GT(second.mean_pose_mse, 0);
  EXPECT_NE(second.mse, second.still_mse) << "ten minutes of slip";
  EXPECT_NE(second.mse, second.recentred_mse) << "another neutral";
  EXPECT_NE(second.ratio, 1);
}

TEST(HeadsetHours, RefusesNobodyAndNoTime) {
  EXPECT_FALSE(study({.wearers = 0}));
  EXPECT_FALSE(study({.minutes = 9}));
  EXPECT_FALSE(study({.seconds = 0.5}));
}

}  // namespace
}  // namespace mien::lab::headset_study_test
