#include "lab/imu/hours_summary.h"

#include <gtest/gtest.h>

#include "mien/face/profile.h"

namespace mien::lab::hours_summary_test {
namespace {

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
}  // namespace mien::lab::hours_summary_test
