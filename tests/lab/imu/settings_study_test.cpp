#include "lab/imu/settings_study.h"

#include <gtest/gtest.h>

#include "tests/project_path.h"
#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::settings_study_test {
namespace {

using Filters = std::vector<std::optional<tracker::JitterSettings>>;

model::ModelFile model_of(const sensor::Rig& rig) {
  return tracker::test::tiny_causal_model(rig.face_sensor_names());
}

TEST(StudyJitter, AStrongerFilterLeavesLessJitterWhateverTheThreads) {
  const sensor::Rig rig = virt::test::three_sensors();
  const Filters filters = {std::nullopt, tracker::JitterSettings{},
                           tracker::JitterSettings{.cutoff_hz = 0.05, .beta = 0.1, .low_pass_hz = 1}};
  JitterRequest request{.performers = 2, .seconds = 5, .seed = 3, .threads = 1};
  const auto one = study_jitter(request, rig, model_of(rig), filters, no_progress);
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_EQ(one->size(), 3U);
  EXPECT_FALSE((*one)[0].settings);
  EXPECT_EQ((*one)[2].settings, filters[2]);
  for (FilteredFigures JitterTrial::*profile : {&JitterTrial::device, &JitterTrial::lab}) {
    const auto& none = (*one)[0].*profile;
    const auto& usual = (*one)[1].*profile;
    const auto& strong = (*one)[2].*profile;
    EXPECT_GT(none.pve_mm, 0);
    EXPECT_GT(none.jitter_ratio, usual.jitter_ratio);
    EXPECT_GT(usual.jitter_ratio, strong.jitter_ratio);
    EXPECT_NE(none.mse, usual.mse);
  }
  request.threads = 2;
  const auto two = study_jitter(request, rig, model_of(rig), filters, no_progress);
  ASSERT_TRUE(two);
  for (std::size_t i = 0; i < filters.size(); ++i) {
    EXPECT_EQ((*one)[i].device.mse, (*two)[i].device.mse);
    EXPECT_EQ((*one)[i].lab.jitter_ratio, (*two)[i].lab.jitter_ratio);
  }
}

TEST(StudyJitter, RefusesNobodyAndAModelThatIsNotLive) {
  const sensor::Rig rig = virt::test::three_sensors();
  const Filters filters(1);
  EXPECT_FALSE(study_jitter({.performers = 0}, rig, model_of(rig), filters, no_progress));
  EXPECT_FALSE(
      study_jitter({}, rig, tracker::test::tiny_model(rig.face_sensor_names()), filters, no_progress));
}

TEST(BestFilter, IsTheClosestOfThoseWithinTheLimitInBothProfiles) {
  const auto trial = [](double device_mm, double device_jitter, double lab_mm, double lab_jitter) {
    return JitterTrial{std::nullopt,
                       {.pve_mm = device_mm, .jitter_ratio = device_jitter},
                       {.pve_mm = lab_mm, .jitter_ratio = lab_jitter}};
  };
  const std::vector<JitterTrial> trials = {trial(0.1, 2, 0.1, 0.1), trial(0.1, 0.1, 0.1, 2),
                                           trial(0.5, 0.6, 0.5, 0.6), trial(0.4, 0.6, 0.5, 0.7),
                                           trial(0.9, 0.1, 0.9, 0.1)};
  EXPECT_EQ(best_filter(trials, 0.7), 3U);
  EXPECT_EQ(best_filter(trials, 0.65), 2U);
  EXPECT_EQ(best_filter(trials, 0.01), std::nullopt);
}

sensor::Rig rig_with(const std::string& faults) {
  sensor::Rig rig = virt::test::three_sensors();
  rig.faults_toml = faults;
  return rig;
}

constexpr DriftRequest kShort{.performers = 2, .seconds = 8, .seed = 3, .threads = 1};

TEST(StudyDrift, PerfectDevicesKeepTheSkinsRotation) {
  const imu::DriftSettings defaults;
  const auto drifts =
      study_drift(kShort, rig_with("mount_rotation_deg = 180\n"), {&defaults, 1}, no_progress);
  ASSERT_TRUE(drifts) << drifts.error().message();
  ASSERT_EQ(drifts->size(), 1U);
  EXPECT_GT(drifts->front().rms_deg, 0);
  EXPECT_LT(drifts->front().rms_deg, 0.6);
  EXPECT_LE(drifts->front().vertical_rms_deg, drifts->front().rms_deg);
}

TEST(StudyDrift, FaultsShowAndSettingsAreCompared) {
  std::vector<imu::DriftSettings> settings(3);
  settings[2].correlation_s = 1;
  const auto drifts = study_drift(
      kShort, rig_with("mount_rotation_deg = 180\ngyro_bias_walk_dps_sqrt_min = 5\n"), settings, no_progress);
  ASSERT_TRUE(drifts) << drifts.error().message();
  EXPECT_GT((*drifts)[0].rms_deg, 0.6);
  EXPECT_EQ((*drifts)[0].rms_deg, (*drifts)[1].rms_deg) << "the same setting meets the same sessions";
  EXPECT_NE((*drifts)[0].rms_deg, (*drifts)[2].rms_deg);
}

TEST(StudyDrift, KnownSkinHoldsHeadings) {
  sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  const DriftRequest request{.performers = 3, .seconds = 40, .seed = 8, .threads = 0};
  const imu::DriftSettings defaults;
  const auto known = study_drift(request, rig, {&defaults, 1}, no_progress);
  ASSERT_TRUE(known) << known.error().message();
  rig.skin.reset();
  const auto unknown = study_drift(request, rig, {&defaults, 1}, no_progress);
  ASSERT_TRUE(unknown);
  EXPECT_LT(known->front().vertical_rms_deg, 0.85 * unknown->front().vertical_rms_deg);
}

TEST(StudyDrift, StopsWhenTold) {
  const imu::DriftSettings defaults;
  const auto stopped =
      study_drift(kShort, rig_with(""), {&defaults, 1}, [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::lab::settings_study_test
