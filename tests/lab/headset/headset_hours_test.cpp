#include "lab/headset/headset_hours.h"

#include <gtest/gtest.h>

#include "mien/headset/answer.h"
#include "tests/headset/small_model.h"
#include "tests/project_path.h"

namespace mien::lab::headset_hours_test {
namespace {

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
}  // namespace mien::lab::headset_hours_test
