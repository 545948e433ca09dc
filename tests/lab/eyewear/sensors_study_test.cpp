#include "lab/eyewear/sensors_study.h"

#include <gtest/gtest.h>

#include "tests/project_path.h"

namespace mien::lab::sensors_study_test {
namespace {

const sensor::Rig& rig() {
  static const sensor::Rig rig = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
  return rig;
}

const builtin_face::MarkerSet& markers() {
  static const builtin_face::MarkerSet set =
      builtin_face::read_markers(project_path("rigs/markers.toml")).value();
  return set;
}

/// The protocol cut short.
SensorsRequest brief() {
  SensorsRequest request;
  request.wearers = 2;
  request.poses = 60;
  request.samples = 300;
  request.test_s = 1;
  request.seed = 3;
  return request;
}

TEST(SensorsStudy, MeasuresEveryWearerTestAndMarker) {
  const auto study = study_sensors(brief(), rig(), markers(), no_progress);
  ASSERT_TRUE(study) << study.error().message();
  EXPECT_EQ(study->markers.size(), 37u);
  EXPECT_EQ(study->faithful.sensors, 20u);
  EXPECT_EQ(study->faithful16.sensors, 16u);
  for (const SensorsMethod* method : {&study->faithful, &study->faithful16, &study->mean_pose}) {
    EXPECT_EQ(method->wearers.size(), 2u);
    EXPECT_EQ(method->tests.size(), kTests);
    EXPECT_EQ(method->markers.size(), 37u);
    const MarkerError& all = method->overall.all;
    EXPECT_GT(all.mean_mm, 0.1);
    EXPECT_GE(all.rmse_mm, all.mean_mm);
    // The regions make up the whole, 22 and 15.
    EXPECT_NEAR(37 * all.mean_mm, 22 * method->overall.eyes_nose.mean_mm + 15 * method->overall.mouth.mean_mm,
                1e-9);
    EXPECT_NEAR(2 * all.mean_mm, method->wearers[0].all.mean_mm + method->wearers[1].all.mean_mm, 1e-9);
  }
  for (const SensorsTraining& training : study->training) {
    EXPECT_EQ(training.samples, 300u);
    EXPECT_LT(training.outliers, 100u);
    EXPECT_GT(training.share, 0.95);
  }
}

TEST(SensorsStudy, DoesNotDependOnThreads) {
  SensorsRequest request = brief();
  request.samples = 100;
  request.threads = 1;
  const auto one = study_sensors(request, rig(), markers(), no_progress);
  request.threads = 2;
  const auto two = study_sensors(request, rig(), markers(), no_progress);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->faithful.overall.all.mean_mm, two->faithful.overall.all.mean_mm);
}

TEST(SensorsStudy, PerfectGlassesKnowMoreThanTheMeanPose) {
  sensor::Rig perfect = rig();
  perfect.faults_toml = "cone_deg = 10\nwhite_at_peak = 1.4\n";
  SensorsRequest request = brief();
  request.wearers = 1;
  const auto study = study_sensors(request, perfect, markers(), no_progress);
  ASSERT_TRUE(study) << study.error().message();
  EXPECT_LT(study->faithful.overall.eyes_nose.mean_mm, 0.6 * study->mean_pose.overall.eyes_nose.mean_mm);
}

TEST(SensorsStudy, RefusesWhatItCannotStudy) {
  const auto code = [](const SensorsRequest& request, const sensor::Rig& with) {
    const auto study = study_sensors(request, with, markers(), no_progress);
    EXPECT_FALSE(study);
    return study ? ErrorCode::io : study.error().code;
  };
  SensorsRequest request = brief();
  request.wearers = 0;
  EXPECT_EQ(code(request, rig()), ErrorCode::bad_usage);
  request = brief();
  request.samples = 10;
  EXPECT_EQ(code(request, rig()), ErrorCode::bad_usage);
  sensor::Rig foreign = rig();
  foreign.faults_toml = "gyro_bias_dps = 1\n";
  EXPECT_EQ(code(brief(), foreign), ErrorCode::malformed);
  const auto stopped =
      study_sensors(brief(), rig(), markers(), [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

TEST(SensorsStudy, KnowsTheEarHooks) {
  EXPECT_EQ(ear_hook_sensors(rig()), (std::vector<std::uint16_t>{16, 17, 18, 19}));
}

}  // namespace
}  // namespace mien::lab::sensors_study_test
