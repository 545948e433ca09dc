#include "mien/study/imu/hours_study.h"

#include <gtest/gtest.h>

#include "mien/model/model_file.h"
#include "mien/study/imu/hours_summary.h"
#include "tests/project_path.h"

namespace mien::study::hours_study_test {
namespace {

struct Installed {
  sensor::Rig rig = sensor::read_rig(project_path("rigs/default.toml")).value();
  model::ModelFile model = model::read_model(project_path("models/live.safetensors")).value();
};

TEST(StudyHours, FortyMinutesOnOneCalibrationLoseNoFace) {
  // The short form of `mien study hours`: the covariance that was not kept symmetric lost both faces after
  // sixteen minutes.
  const Installed installed;
  const auto runs = study_hours({.scripts = {performer::Block::mixed, performer::Block::reading},
                                 .first_seed = 9,
                                 .seeds = 1,
                                 .minutes = 40},
                                installed.rig, installed.model, no_progress);
  ASSERT_TRUE(runs) << runs.error().message();
  ASSERT_EQ(runs->size(), 2U);
  EXPECT_EQ(share_within(*runs, 1.6), 1);
  for (const HoursRun& run : *runs) {
    ASSERT_EQ(run.pieces.size(), 4U);
    for (const HoursPiece& piece : run.pieces) {
      EXPECT_NEAR(static_cast<double>(piece.frames), 36000, 3);
      EXPECT_LT(piece.rotation_rms_deg, 5) << piece.begin_s;
      EXPECT_LT(piece.missing, 0.02) << piece.begin_s;
      EXPECT_LT(piece.worst_bias, 0.25) << piece.begin_s;
      EXPECT_GT(piece.nees, 0.3) << piece.begin_s;
      EXPECT_LT(piece.nees, 3.5) << piece.begin_s;
      EXPECT_GT(piece.mse.frozen, 2 * piece.mse.device) << "what drifts is tracked";
    }
  }
}

TEST(StudyHours, AHeldExpressionIsMeasured) {
  const Installed installed;
  HeldExpression smile{.shapes = {face::shape("mouthSmile_L"), face::shape("mouthSmile_R")}, .value = 0.8F};
  smile.begin_s = 20;
  smile.end_s = 60;
  const HoursRequest request{
      .scripts = {performer::Block::reading}, .seeds = 1, .minutes = 1, .held = {smile}};
  const auto runs = study_hours(request, installed.rig, installed.model, no_progress);
  ASSERT_TRUE(runs) << runs.error().message();
  ASSERT_EQ(runs->front().pieces.front().held.size(), 1U);
  EXPECT_GT(runs->front().pieces.front().held.front().lab, 0.4);
  EXPECT_GT(runs->front().pieces.front().held.front().device, 0.3);
  // The same request gives the same figures.
  const auto again = study_hours(request, installed.rig, installed.model, no_progress);
  ASSERT_TRUE(again);
  EXPECT_EQ(runs->front().pieces.front().mse.device, again->front().pieces.front().mse.device);
}

TEST(StudyHours, SaysWhatIsMissing) {
  const Installed installed;
  EXPECT_FALSE(study_hours({.scripts = {}}, installed.rig, installed.model, no_progress));
  EXPECT_FALSE(study_hours({.scripts = {performer::Block::mixed}, .seeds = 0}, installed.rig, installed.model,
                           no_progress));
  EXPECT_FALSE(study_hours({.scripts = {performer::Block::mixed}, .minutes = 0}, installed.rig,
                           installed.model, no_progress));
  const auto stopped = study_hours({.scripts = {performer::Block::mixed}, .seeds = 1}, installed.rig,
                                   installed.model, [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace mien::study::hours_study_test
