#include "lab/imu/loss.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>
#include <utility>

#include "mien/builtin_face/builtin_face.h"
#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::loss_test {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

sensor::Rig rig() {
  sensor::Rig out = virt::test::three_sensors();
  out.faults_toml =
      "mount_rotation_deg = 180\nclock_offset_s = [1, 50]\nclock_drift_ppm = 20\nradio_delay_min_ms = 1\n";
  return out;
}

LossRequest brief(unsigned threads = 1) {
  LossRequest request;
  request.performers = 2;
  request.seconds = 3;
  request.seed = 3;
  request.threads = threads;
  return request;
}

Result<LossStudy> study(const LossRequest& request, const std::vector<LossCondition>& conditions) {
  return study_loss(request, rig(), tracker::test::tiny_causal_model(kSensors), conditions, no_progress);
}

LossRow row(Fault fault, double amount, const std::string& sensor, double rise) {
  LossRow out{.condition = {fault, amount, sensor}};
  out.rise = rise;
  return out;
}

void expect_every_performance_under_every_condition(const LossStudy& whole) {
  const std::vector<LossCondition> conditions = loss_conditions(rig());
  ASSERT_EQ(whole.rows.size(), conditions.size() + 1);
  EXPECT_EQ(whole.rows[0].condition.fault, Fault::none);
  for (std::size_t i = 0; i < whole.rows.size(); ++i) {
    const LossRow& row = whole.rows[i];
    if (i > 0) {
      EXPECT_EQ(row.condition.name(), conditions[i - 1].name());
    }
    // Two performers of three seconds; the last frames of one that is heard late may be missing.
    EXPECT_NEAR(static_cast<double>(row.frames), 360, 40) << row.condition.name();
    EXPECT_GT(row.mse, 0);
    EXPECT_GT(row.mse_observed, 0);
    EXPECT_GT(row.pve_mm, 0);
    EXPECT_GT(row.truth_step, 0);
    EXPECT_LE(row.largest_step, 1);
    EXPECT_EQ(row.performance_mse.size(), 2U);
    EXPECT_EQ(row.unsound, 0U) << row.condition.name();
    EXPECT_EQ(row.mistold, 0U) << row.condition.name();
    EXPECT_DOUBLE_EQ(row.rise, row.mse / whole.rows[0].mse - 1);
    const double known = whole.mean_pose_mse - whole.rows[0].mse;
    EXPECT_DOUBLE_EQ(row.given_up, known > 0 ? (row.mse - whole.rows[0].mse) / known : 0);
  }
  EXPECT_GT(whole.mean_pose_mse, 0);
}

void expect_what_the_conditions_say(const LossStudy& whole) {
  const LossRow& clean = whole.rows[0];
  EXPECT_EQ(clean.rise, 0);
  EXPECT_EQ(clean.observed, 1) << "perfect devices";
  EXPECT_GT(clean.rotation_rms_deg, 0);
  EXPECT_LT(clean.rotation_rms_deg, 1);
  const LossRow* lag = whole.find(Fault::lag, 100);
  ASSERT_NE(lag, nullptr);
  EXPECT_EQ(lag->observed, 1) << "late alike is not lost";
  // The last frames may never be heard of, and clocks are known a little otherwise.
  EXPECT_NEAR(lag->mse, clean.mse, 0.05 * clean.mse);
  for (const LossRow& row : whole.rows)
    if (row.condition.fault == Fault::sensor_silent) {
      EXPECT_EQ(row.observed, 0.5) << row.condition.sensor;
    }
  const LossRow* fifth = whole.find(Fault::loss, 20);
  ASSERT_NE(fifth, nullptr);
  EXPECT_NE(fifth->mse, clean.mse);
  const LossRow* bursts = whole.find(Fault::bursts, 10);
  ASSERT_NE(bursts, nullptr);
  EXPECT_LT(bursts->observed, 1);
  EXPECT_GT(bursts->rotation_rms_deg, clean.rotation_rms_deg);
  const LossRow* head = whole.find(Fault::head_silent, 2);
  ASSERT_NE(head, nullptr);
  EXPECT_LT(head->observed, 0.7);
  EXPECT_EQ(whole.find(Fault::loss, 11), nullptr);
}

void expect_the_same_on_two_threads_and_beside_others(const LossStudy& whole) {
  const std::vector<LossCondition> some = {{Fault::loss, 10, {}}, {Fault::restart, 0, {}}};
  const auto one = study(brief(1), some);
  const auto two = study(brief(2), some);
  ASSERT_TRUE(one) << one.error().message();
  ASSERT_TRUE(two) << two.error().message();
  for (std::size_t i = 0; i < one->rows.size(); ++i) {
    EXPECT_EQ(one->rows[i].mse, two->rows[i].mse);
    EXPECT_EQ(one->rows[i].performance_mse, two->rows[i].performance_mse);
  }
  EXPECT_EQ(one->rows[1].mse, whole.find(Fault::loss, 10)->mse) << "whatever else is studied";
}

/// All conditions are studied once for everything that is asked of them.
TEST(StudyLoss, HearsEveryPerformanceUnderEveryCondition) {
  const auto done = study(brief(), loss_conditions(rig()));
  ASSERT_TRUE(done) << done.error().message();
  expect_every_performance_under_every_condition(*done);
  expect_what_the_conditions_say(*done);
  expect_the_same_on_two_threads_and_beside_others(*done);
}

TEST(StudyLoss, PlaysGivenMotions) {
  LossRequest request = brief();
  request.motions.push_back({virt::test::talking(120), 0});
  request.faces.push_back(builtin_face::make_builtin());
  const auto played = study(request, {});
  ASSERT_TRUE(played) << played.error().message();
  ASSERT_EQ(played->rows.size(), 1U);
  EXPECT_EQ(played->rows[0].performance_mse.size(), 1U);
  EXPECT_NEAR(static_cast<double>(played->rows[0].frames), 120, 3);

  request.faces.clear();
  const auto faceless = study(request, {});
  ASSERT_FALSE(faceless);
  EXPECT_EQ(faceless.error().code, ErrorCode::bad_usage);
}

TEST(StudyLoss, SaysWhatCannotBeStudied) {
  const auto unknown = study(brief(), {{Fault::sensor_silent, 0, "nose"}});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::not_found);
  EXPECT_THAT(unknown.error().message(), HasSubstr("nose"));

  const auto too_many = study(brief(), {{Fault::sensors_silent, 3, {}}});
  ASSERT_FALSE(too_many);
  EXPECT_EQ(too_many.error().code, ErrorCode::not_found);

  const auto window = study_loss(brief(), rig(), tracker::test::tiny_model(kSensors), {}, no_progress);
  ASSERT_FALSE(window);
  EXPECT_EQ(window.error().code, ErrorCode::mismatch);

  const auto stopped = study_loss(brief(), rig(), tracker::test::tiny_causal_model(kSensors), {},
                                  [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

TEST(LossStudy, KnowsItsPromises) {
  LossStudy out;
  EXPECT_EQ(out.worst_sensor(), nullptr);
  EXPECT_TRUE(out.kept()) << "nothing was promised of nothing";
  out.rows = {row(Fault::none, 0, {}, 0),
              row(Fault::loss, 10, {}, 0.25),
              row(Fault::loss, 20, {}, 2),
              row(Fault::sensor_silent, 0, "a", 0.1),
              row(Fault::sensor_silent, 0, "b", 0.3),
              row(Fault::sensors_silent, 2, {}, 3)};
  ASSERT_NE(out.worst_sensor(), nullptr);
  EXPECT_EQ(out.worst_sensor()->condition.sensor, "b");
  EXPECT_TRUE(out.kept());
  for (const auto& [index, rise] : {std::pair{1U, 0.26}, {3U, 0.31}, {1U, kNone}, {4U, kNone}}) {
    LossStudy broken = out;
    broken.rows[index].rise = rise;
    EXPECT_FALSE(broken.kept()) << index << " " << rise;
  }
  LossStudy unsound = out;
  unsound.rows[2].unsound = 1;
  EXPECT_EQ(unsound.unsound(), 1U);
  EXPECT_FALSE(unsound.kept());
  LossStudy mistold = out;
  mistold.rows[2].mistold = 2;
  EXPECT_EQ(mistold.mistold(), 2U);
  EXPECT_FALSE(mistold.kept());
}

using ::testing::HasSubstr;
using ::testing::Not;

LossRow measured_row(Fault fault, double amount, const std::string& sensor, double mse) {
  LossRow out{.condition = {fault, amount, sensor}};
  out.mse = mse;
  out.rise = mse / 0.01 - 1;
  return out;
}

LossStudy small() {
  LossStudy out;
  out.mean_pose_mse = 0.02;
  out.rows = {measured_row(Fault::none, 0, {}, 0.01), measured_row(Fault::loss, 10, {}, 0.0111),
              measured_row(Fault::bursts, 10, {}, 0.0123)};
  return out;
}

TEST(LossReport, ShowsThePromisesTheCurveAndEveryRow) {
  LossStudy study = small();
  study.rows.push_back(measured_row(Fault::sensor_silent, 0, "chin", 0.0107));
  const std::string html = loss_report(study, "who <performed>").html();
  EXPECT_THAT(html, HasSubstr("who &lt;performed&gt;"));
  EXPECT_THAT(html, HasSubstr("+11.0 %"));
  EXPECT_THAT(html, HasSubstr("+25.0 % is promised"));
  EXPECT_THAT(html, HasSubstr("Without chin, the worst to lose"));
  EXPECT_THAT(html, HasSubstr("in bursts of ten packets"));
  EXPECT_THAT(html, HasSubstr("Weight error without one sensor"));
  for (const LossRow& one : study.rows) EXPECT_THAT(html, HasSubstr(one.condition.name()));
}

TEST(LossReport, LeavesOutWhatWasNotStudied) {
  const std::string html = loss_report(small(), "").html();
  EXPECT_THAT(html, Not(HasSubstr("the worst to lose")));
  EXPECT_THAT(html, Not(HasSubstr("Weight error without one sensor")));
}

sensor::Rig whole_rig() {
  return virt::test::three_sensors();
}

TEST(LossConditions, FitTheRigAndHaveNamesOfTheirOwn) {
  const std::vector<LossCondition> conditions = loss_conditions(whole_rig());
  std::set<std::string> names, silent;
  for (const LossCondition& condition : conditions) {
    EXPECT_FALSE(condition.name().empty());
    names.insert(condition.name());
    EXPECT_NE(condition.fault, Fault::none);
    EXPECT_NE(condition.fault, Fault::sensors_silent) << "the rig has no more than two on the face";
    if (condition.fault == Fault::sensor_silent) silent.insert(condition.sensor);
  }
  EXPECT_EQ(names.size(), conditions.size());
  EXPECT_EQ(silent, (std::set<std::string>{"mentalis", "buccinator_L"}));
}

TEST(LossConditions, DrawWhatTheyDoNotName) {
  const auto one = impairment({Fault::sensors_silent, 1, {}}, whole_rig(), 10, 20, Random(1));
  const auto both = impairment({Fault::sensors_silent, 2, {}}, whole_rig(), 10, 20, Random(1));
  ASSERT_TRUE(one && both);
  ASSERT_EQ(one->troubles.silences.size(), 1U);
  ASSERT_EQ(both->troubles.silences.size(), 2U);
  EXPECT_EQ(both->troubles.silences[0].sensor, one->troubles.silences[0].sensor);
  EXPECT_NE(both->troubles.silences[1].sensor, one->troubles.silences[0].sensor);
  const auto restart = impairment({Fault::restart, 0, {}}, whole_rig(), 10, 20, Random(1));
  ASSERT_TRUE(restart);
  EXPECT_EQ(restart->troubles.restarts.at(0).at_s, 15);
  const auto bursts = impairment({Fault::bursts, 10, {}}, whole_rig(), 10, 20, Random(1));
  ASSERT_TRUE(bursts);
  EXPECT_DOUBLE_EQ(bursts->network.burst_share, 0.1);
}

TEST(LossConditions, FreezeSilenceAndSpoil) {
  const auto frozen = impairment({Fault::frozen, 1, {}}, whole_rig(), 10, 20, Random(1));
  ASSERT_TRUE(frozen);
  ASSERT_EQ(frozen->troubles.frozen.size(), 1U);
  EXPECT_EQ(frozen->troubles.frozen[0].from_s, 10);
  EXPECT_EQ(frozen->troubles.frozen[0].to_s, 20);
  const auto silent = impairment({Fault::all_silent, 2, {}}, whole_rig(), 10, 20, Random(1));
  ASSERT_TRUE(silent);
  EXPECT_EQ(silent->troubles.silences.at(0).sensor, std::nullopt);
  EXPECT_EQ(silent->troubles.silences[0].to_s, 17);
  EXPECT_DOUBLE_EQ(impairment({Fault::corrupted, 5, {}}, whole_rig(), 10, 20, Random(1))->network.corrupted,
                   0.05);
  EXPECT_DOUBLE_EQ(impairment({Fault::truncated, 5, {}}, whole_rig(), 10, 20, Random(1))->network.truncated,
                   0.05);
}

TEST(LossConditions, SayWhatTheRigLacks) {
  for (const LossCondition& condition :
       {LossCondition{Fault::sensor_silent, 0, "nose"}, LossCondition{Fault::sensors_silent, 3, {}},
        LossCondition{Fault::frozen, 3, {}}}) {
    const auto wrong = impairment(condition, whole_rig(), 0, 1, Random(1));
    ASSERT_FALSE(wrong);
    EXPECT_EQ(wrong.error().code, ErrorCode::not_found);
  }
}

}  // namespace
}  // namespace mien::lab::loss_test
