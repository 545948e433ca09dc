#include "mien/study/speech/lag_study.h"

#include <gtest/gtest.h>

#include "tests/study/speech/letter_speaker.h"

namespace mien::study::lag_study_test {
namespace {

TEST(LagStudy, SensorsAreLostForTwoSecondsOfEightFromAMinuteOn) {
  int lost = 0;
  for (int i = 0; i < 12'000; ++i) lost += is_lost_in_reading(0.01 * i) ? 1 : 0;
  EXPECT_EQ(lost, 7 * 200);
  EXPECT_FALSE(is_lost_in_reading(59.99));
  EXPECT_TRUE(is_lost_in_reading(60));
  EXPECT_FALSE(is_lost_in_reading(62.01));
  EXPECT_TRUE(is_lost_in_reading(68.01));
  EXPECT_FALSE(is_lost_in_reading(kLagReading_s)) << "nor is what follows of a line counted";
}

TEST(LagStudy, BeliefIsCountedFromTheReadingsBegin) {
  std::vector<bool> believed(600);
  std::vector<Duration> offset(600);
  const LagFollowed never = follow_lag(believed, offset);
  EXPECT_FALSE(never.believed_s);
  EXPECT_EQ(never.believed_share, 0);
  std::fill(believed.begin() + 150, believed.begin() + 300, true);
  offset.back() = std::chrono::milliseconds(-40);
  const LagFollowed once = follow_lag(believed, offset);
  EXPECT_NEAR(once.believed_s.value(), 2.5, 1e-12);
  EXPECT_NEAR(once.believed_share, 0.25, 1e-12);
  EXPECT_NEAR(once.offset_s, -0.040, 1e-12);
  EXPECT_FALSE(follow_lag({}, {}).believed_s);
}

TEST(LagStudy, OtherSensorsAreRefusedBeforeAnybodySpeaks) {
  const Speaker nobody = [](const std::string&, const std::string&, int) -> Result<SpokenLine> {
    ADD_FAILURE() << "somebody spoke";
    return SpokenLine();
  };
  SpokenScene scene;
  scene.rig.name = "microphone";
  scene.rig.sensors.push_back({.name = "microphone", .kind = "speech", .role = "face"});
  auto refused = study_lag({}, scene, nobody, no_progress);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  scene.rig.sensors.push_back({.name = "jaw", .kind = "imu", .role = "face"});
  refused = study_lag({}, scene, nobody, no_progress);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage) << "several kinds";
}

}  // namespace
}  // namespace mien::study::lag_study_test
