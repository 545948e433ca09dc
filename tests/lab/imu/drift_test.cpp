#include "lab/imu/drift.h"

#include <gtest/gtest.h>

#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::drift_test {
namespace {

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
  ASSERT_EQ(drifts->front().performer_rms_deg.size(), 2U);
  EXPECT_LE(drifts->front().performer_rms_deg.front(), drifts->front().rms_deg);
  EXPECT_GE(drifts->front().performer_rms_deg.back(), drifts->front().rms_deg);
  EXPECT_EQ(drifts->front().missing, 0);
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
}  // namespace mien::lab::drift_test
