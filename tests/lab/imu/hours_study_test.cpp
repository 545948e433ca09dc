#include "lab/imu/hours_study.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

#include "mien/face/profile.h"
#include "mien/model/model_file.h"
#include "tests/project_path.h"

namespace mien::lab::hours_study_test {
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
  performer::HeldExpression smile{.shapes = {face::shape("mouthSmile_L"), face::shape("mouthSmile_R")},
                                  .value = 0.8F};
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

TEST(StudyHours, ScenariosAreWhatTheySay) {
  const Installed installed;
  const auto faults = virt::parse_faults(installed.rig.faults_toml, "rig").value();
  const virt::DeviceFaults perfect{.mount_rotation_deg = 180};
  std::set<std::string_view> names;
  for (const HoursScenario& scenario : hours_scenarios()) {
    EXPECT_TRUE(names.insert(scenario.name).second) << scenario.name;
    EXPECT_FALSE(scenario.description.empty()) << scenario.name;
    const auto found = find_hours_scenario(scenario.name);
    ASSERT_TRUE(found) << scenario.name;
    EXPECT_EQ(found->description, scenario.description);
  }
  EXPECT_EQ(hours_scenarios().front().name, "default");
  EXPECT_EQ(hours_scenarios().front().faults, nullptr);
  EXPECT_EQ(find_hours_scenario("perfect")->faults(faults), perfect);
  // A single fault is the rig's, and alone.
  virt::DeviceFaults slip = find_hours_scenario("slip")->faults(faults);
  EXPECT_EQ(std::exchange(slip.slip_deg_per_sqrt_min, 0), faults.slip_deg_per_sqrt_min);
  EXPECT_EQ(slip, perfect);
  virt::DeviceFaults bias = find_hours_scenario("bias")->faults(faults);
  EXPECT_EQ(std::exchange(bias.gyro_bias_dps, 0), faults.gyro_bias_dps);
  EXPECT_EQ(std::exchange(bias.gyro_bias_walk_dps_sqrt_min, 0), faults.gyro_bias_walk_dps_sqrt_min);
  EXPECT_EQ(bias, perfect);
  EXPECT_EQ(find_hours_scenario("slip_x3")->faults(faults).slip_deg_per_sqrt_min,
            3 * faults.slip_deg_per_sqrt_min);
  const auto unknown = find_hours_scenario("earthquake");
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
  EXPECT_NE(unknown.error().message().find("put_on_again"), std::string::npos) << unknown.error().message();
}

TEST(StudyHours, WhatHappensToASensorIsSeenInIt) {
  // A jump by 30 degrees in minute 0.5, and a gap after which the heading is 25 degrees off. Devices are
  // perfect, so that in *frozen* nothing else is off.
  const Installed installed;
  HoursScenario jump = find_hours_scenario("perfect").value();
  jump.name = "early jump";
  jump.event = {.begin_min = 0.5, .end_min = 0.5, .turn_deg = 30};
  HoursScenario gap = jump;
  gap.name = "early gap";
  gap.event = {.begin_min = 0.4, .end_min = 0.5, .silent = true, .heading_deg = 25};
  HoursScenario quiet{.name = "quiet", .description = "nothing happens"};
  const auto runs = study_hours({.scripts = {performer::Block::reading},
                                 .scenarios = {quiet, jump, gap},
                                 .first_seed = 3,
                                 .seeds = 1,
                                 .minutes = 1},
                                installed.rig, installed.model, no_progress);
  ASSERT_TRUE(runs) << runs.error().message();
  ASSERT_EQ(runs->size(), 3U);
  EXPECT_EQ(runs->at(0).sensor, "");
  EXPECT_EQ(runs->at(0).pieces.front().sensor_rms_deg, 0);
  for (const std::size_t i : {1U, 2U}) {
    const HoursRun& run = runs->at(i);
    EXPECT_EQ(run.event_end_s, 30) << run.scenario;
    EXPECT_TRUE(installed.rig.find(run.sensor)) << run.sensor;
    // Off for thirty seconds: of sixty, or of the fifty-four in which it is not silent.
    const double off_deg = i == 1 ? 30 * std::sqrt(0.5) : 25 * std::sqrt(30.0 / 54);
    EXPECT_NEAR(run.pieces.front().frozen_sensor_rms_deg, off_deg, 0.15 * off_deg) << run.scenario;
    EXPECT_GT(run.pieces.front().sensor_rms_deg, 1) << run.scenario;
  }
  EXPECT_GT(runs->at(2).pieces.front().missing, 0.1 / 11) << "silent for a tenth of the time";
}

TEST(StudyHours, ARecordedMotionIsRepeated) {
  // Twelve seconds: a frame a second does not tell where it begins anew.
  const Installed installed;
  face::Motion motion{.name = "recorded", .frames = {}};
  for (int i = 0; i <= 120; ++i) {
    face::MotionFrame& frame = motion.frames.emplace_back();
    frame.time_s = 0.1 * i;
    frame.weights[face::shape("jawOpen")] = 0.3F + 0.3F * std::sin(0.9F * static_cast<float>(i) / 10);
  }
  const HoursRequest request{.motions = {motion}, .seeds = 1, .minutes = 1};
  const auto runs = study_hours(request, installed.rig, installed.model, no_progress);
  ASSERT_TRUE(runs) << runs.error().message();
  ASSERT_EQ(runs->size(), 1U);
  EXPECT_EQ(runs->front().script, "recorded");
  EXPECT_NEAR(static_cast<double>(runs->front().pieces.front().frames), 3600, 3);
  EXPECT_LT(runs->front().pieces.front().mse.lab, 0.05);
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

HoursPiece piece(double mse, double ratio, double nees, double missing, double bias) {
  return {.frames = 100,
          .mse = {.device = mse, .lab = 0.01, .known = 0.02, .frozen = 0.3},
          .ratio = ratio,
          .worst_shape = face::shape("jawOpen"),
          .worst_bias = bias,
          .rotation_rms_deg = 100 * mse,
          .nees = nees,
          .missing = missing};
}

const std::vector<HoursRun> kRuns = {
    {"mixed", "default", 1, "", 0, {piece(0.01, 1, 1, 0.01, 0), piece(0.02, 1.2, 2, 0.02, 0.1)}},
    {"reading", "default", 1, "", 0, {piece(0.01, 1, 1, 0, 0), piece(0.01, 1, 1, 0, -0.1)}},
    {"mixed", "default", 2, "", 0, {piece(0.03, 1, 2, 0.03, 0), piece(0.04, 1.5, 4, 0.01, 0.05)}}};

TEST(HoursSummary, IsOneOfEachScript) {
  const std::vector<HoursSummary> all = summarise(kRuns);
  ASSERT_EQ(all.size(), 2U);
  const HoursSummary& mixed = all.front();
  EXPECT_EQ(mixed.script, "mixed");
  EXPECT_EQ(mixed.runs, 2U);
  EXPECT_DOUBLE_EQ(mixed.first_mse.device, 0.02);
  EXPECT_DOUBLE_EQ(mixed.last_mse.device, 0.03);
  EXPECT_DOUBLE_EQ(mixed.last_mse.lab, 0.01);
  EXPECT_EQ(mixed.worst_ratio, 1.5);
  EXPECT_EQ(mixed.within_most, 0.5);
  EXPECT_EQ(mixed.within_all, 1);
  EXPECT_DOUBLE_EQ(mixed.first_rotation_deg, 2);
  EXPECT_DOUBLE_EQ(mixed.worst_rotation_deg, 3);
  EXPECT_DOUBLE_EQ(mixed.least_nees, 1.5);
  EXPECT_DOUBLE_EQ(mixed.most_nees, 3);
  EXPECT_DOUBLE_EQ(mixed.first_missing, 0.02);
  EXPECT_EQ(mixed.worst_missing, 0.03);
  EXPECT_EQ(mixed.worst_bias, 0.1);
  EXPECT_EQ(mixed.worst_shape, face::shape("jawOpen"));
  EXPECT_EQ(all.back().script, "reading");
  EXPECT_EQ(all.back().worst_bias, 0) << "no bias grew";
}

TEST(HoursSummary, ASensorIsJudgedTenMinutesAfterItsEvent) {
  HoursRun run{.script = "mixed", .scenario = "jump", .seed = 1, .sensor = "mentalis", .event_end_s = 2400};
  for (int i = 0; i < 8; ++i) {
    HoursPiece& one = run.pieces.emplace_back(piece(0.01, 1, 1, 0, 0));
    one.begin_s = performer::kPieceS * i;
    one.sensor_rms_deg = i;
    one.frozen_sensor_rms_deg = 2 * i;
  }
  const HoursSummary jump = summarise({&run, 1}).front();
  EXPECT_EQ(jump.scenario, "jump");
  EXPECT_EQ(jump.sensor_deg, 5);
  EXPECT_EQ(jump.frozen_sensor_deg, 10);
  run.scenario = "default";
  EXPECT_EQ(summarise(std::vector<HoursRun>{run, kRuns[0]}).size(), 1U) << "by script and scenario";
}

TEST(HoursSummary, OfNoRunsIsNone) {
  EXPECT_TRUE(summarise({}).empty());
  EXPECT_EQ(share_within({}, 1), 0);
}

}  // namespace
}  // namespace mien::lab::hours_study_test
