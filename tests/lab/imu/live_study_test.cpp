#include "lab/imu/live_study.h"

#include <gmock/gmock.h>

#include <cmath>
#include <set>
#include <utility>

#include "mien/builtin_face/builtin_face.h"
#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::live_study_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

sensor::Rig rig() {
  sensor::Rig out = virt::test::three_sensors();
  out.faults_toml =
      "mount_rotation_deg = 180\nmount_position_mm = 1\nclock_offset_s = [1, 50]\nradio_delay_min_ms = 1\n"
      "gyro_noise_dps_sqrt_hz = 0.015\n";
  return out;
}

const tracker::WindowSolver& window() {
  static const auto solver = tracker::WindowSolver::create(tracker::test::tiny_model(kSensors)).value();
  return solver;
}

LiveModels models() {
  LiveModels out;
  out.causal.push_back({"live", tracker::test::tiny_causal_model(kSensors)});
  out.causal.push_back({"other", tracker::test::tiny_causal_model(kSensors, 2)});
  out.window = &window();
  out.window_steps = {2, 1};
  return out;
}

LiveRequest brief(std::vector<LiveCondition> conditions = {}, unsigned threads = 1) {
  LiveRequest request;
  request.conditions = std::move(conditions);
  request.performers = 2;
  request.seconds = 1.5;
  request.round_s = 1;
  request.rounds = 3;
  request.other_faults = virt::test::mild_faults();
  request.seed = 3;
  request.threads = threads;
  return request;
}

Result<LiveStudy> study(const LiveRequest& request) {
  return study_live(request, rig(), models(), no_progress);
}

const LiveRow& row_of(const LiveSet& set, LiveCondition condition) {
  return *std::ranges::find(set.rows, condition, &LiveRow::condition);
}

TEST(LiveConditions, HaveNamesThatComeBack) {
  std::set<std::string_view> names;
  for (std::size_t c = 0; c < kLiveConditionCount; ++c) {
    const auto condition = static_cast<LiveCondition>(c);
    names.insert(names_of(condition).name);
    EXPECT_EQ(parse_live_condition(names_of(condition).name).value(), condition);
  }
  EXPECT_EQ(names.size(), kLiveConditionCount);
  const auto wrong = parse_live_condition("flying");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::not_found);
  EXPECT_THAT(wrong.error().message(), HasSubstr("other_simulator"));
}

void expect_every_method_under_every_condition(const LiveSet& whole) {
  const std::vector<LiveCondition> conditions = live_conditions(rig());
  EXPECT_EQ(conditions.size(), kLiveConditionCount - 1) << "two face sensors: three cannot be lost";
  std::vector<LiveCondition> met;
  std::set<std::string> titles;
  for (const LiveRow& row : whole.rows) {
    if (met.empty() || met.back() != row.condition) met.push_back(row.condition);
    titles.insert(row.title);
    std::vector<std::string> names;
    for (const LiveMethod& method : row.methods) names.push_back(method.name);
    EXPECT_THAT(names, ElementsAre("live", "other", "window, 2 steps", "window, 1 step", "ridge", "hold last",
                                   "mean pose", "sensor bound"));
    const double seconds = row.condition == LiveCondition::long_session ? 1 : 1.5;
    EXPECT_NEAR(static_cast<double>(row.frames), 2 * seconds * 60, 20) << row.title;
    EXPECT_GT(row.rotation_rms_deg, 0) << row.title;
    for (const LiveMethod& method : row.methods) {
      EXPECT_EQ(method.performers.size(), 2U);
      for (const Measure measure : {Measure::pve, Measure::pve_face, Measure::landmarks, Measure::mse}) {
        ASSERT_TRUE(method.over(measure)) << row.title << ", " << method.name;
        EXPECT_GT(method.over(measure)->mean, 0) << row.title << ", " << method.name;
      }
    }
    EXPECT_FALSE(row.find(kSensorBound)->over(Measure::jitter)) << "of one frame";
    EXPECT_LT(row.find(kMeanPose)->over(Measure::jitter)->mean, 0.01) << "it does not move";
    EXPECT_EQ(row.find("nobody"), nullptr);
  }
  EXPECT_EQ(met, conditions);
  EXPECT_EQ(titles.size(), whole.rows.size());
  EXPECT_EQ(whole.rows.size(), conditions.size() + 1) << "a long session has two rows";
}

void expect_conditions_to_do_what_they_say(const LiveSet& whole) {
  const LiveRow& lab = row_of(whole, LiveCondition::lab);
  EXPECT_NEAR(lab.rotation_rms_deg, std::sqrt(3.0), 0.2) << "a degree an axis";
  const LiveRow& seen = row_of(whole, LiveCondition::seen);
  EXPECT_GT(seen.observed, 0.95);
  EXPECT_NEAR(row_of(whole, LiveCondition::one_lost).observed, 0.5, 0.05);
  EXPECT_GT(row_of(whole, LiveCondition::bursts).rotation_rms_deg, 1.1 * seen.rotation_rms_deg)
      << "what was lost in a gap is not known afterwards, though it may be short enough to hold values over "
         "it";
  // Who does the same has the same truth, however it is sensed.
  const auto mean_pose = [&](LiveCondition condition) {
    return row_of(whole, condition).find(kMeanPose)->over(Measure::mse)->mean;
  };
  for (const LiveCondition same : {LiveCondition::unseen, LiveCondition::remount, LiveCondition::walking,
                                   LiveCondition::running, LiveCondition::other_simulator})
    EXPECT_NEAR(mean_pose(same), mean_pose(LiveCondition::seen), 0.05 * mean_pose(LiveCondition::seen));
  EXPECT_GT(std::abs(mean_pose(LiveCondition::eating) / mean_pose(LiveCondition::seen) - 1), 0.05);
  const auto error = [&](LiveCondition condition) {
    return row_of(whole, condition).methods.front().over(Measure::mse)->mean;
  };
  for (const LiveCondition other : {LiveCondition::unseen, LiveCondition::remount, LiveCondition::walking,
                                    LiveCondition::running, LiveCondition::other_simulator})
    EXPECT_NE(error(other), error(LiveCondition::seen)) << names_of(other).name;
}

void expect_a_long_session_to_repeat_itself(const LiveSet& whole) {
  std::vector<const LiveRow*> rows;
  for (const LiveRow& row : whole.rows)
    if (row.condition == LiveCondition::long_session) rows.push_back(&row);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_THAT(rows[0]->title, HasSubstr("first 1 s"));
  EXPECT_THAT(rows[1]->title, HasSubstr("after 4 s"));
  const double first = rows[0]->find(kMeanPose)->over(Measure::mse)->mean;
  EXPECT_NEAR(rows[1]->find(kMeanPose)->over(Measure::mse)->mean, first, 0.02 * first);
}

void expect_the_bound_between_nothing_and_all(const LiveSet& whole) {
  const LiveRow& lab = row_of(whole, LiveCondition::lab);
  const double bound = lab.find(kSensorBound)->over(Measure::mse)->mean;
  EXPECT_LT(bound, lab.find(kMeanPose)->over(Measure::mse)->mean);
  EXPECT_GT(bound, 0.2 * lab.find(kMeanPose)->over(Measure::mse)->mean) << "two sensors tell little";
  EXPECT_GT(row_of(whole, LiveCondition::one_lost).find(kSensorBound)->over(Measure::mse)->mean,
            row_of(whole, LiveCondition::seen).find(kSensorBound)->over(Measure::mse)->mean);
}

void expect_the_same_on_two_threads_and_for_other_rows(const LiveSet& whole) {
  const auto some = study(brief({LiveCondition::bursts, LiveCondition::eating}, 2));
  ASSERT_TRUE(some) << some.error().message();
  const LiveSet& set = some->sets.front();
  ASSERT_EQ(set.rows.size(), 2U);
  for (const LiveRow& row : set.rows)
    for (std::size_t m = 0; m < row.methods.size(); ++m)
      EXPECT_EQ(row.methods[m].performers, row_of(whole, row.condition).methods[m].performers) << row.title;
}

/// All conditions that the rig allows are studied once for everything that is asked of them.
TEST(StudyLive, MeasuresEveryMethodUnderEveryConditionOfTheRig) {
  const auto done = study(brief());
  ASSERT_TRUE(done) << done.error().message();
  ASSERT_EQ(done->sets.size(), 1U);
  const LiveSet& whole = done->sets.front();
  expect_every_method_under_every_condition(whole);
  expect_conditions_to_do_what_they_say(whole);
  expect_a_long_session_to_repeat_itself(whole);
  expect_the_bound_between_nothing_and_all(whole);
  expect_the_same_on_two_threads_and_for_other_rows(whole);
}

TEST(StudyLive, PlaysGivenMotions) {
  LiveRequest request =
      brief({LiveCondition::seen, LiveCondition::eating, LiveCondition::rapid, LiveCondition::long_session});
  request.performers = 0;
  request.motions.push_back({virt::test::talking(240, false), 0});
  request.faces.push_back(builtin_face::make_builtin());
  request.motions_are = "one who talks";
  request.given_seconds = 3;
  const auto played = study(request);
  ASSERT_TRUE(played) << played.error().message();
  ASSERT_EQ(played->sets.size(), 1U);
  EXPECT_EQ(played->sets[0].who, "one who talks");
  ASSERT_EQ(played->sets[0].rows.size(), 4U) << "nobody makes him eat";
  EXPECT_NEAR(static_cast<double>(played->sets[0].rows[0].frames), 180, 4) << "its beginning";
  EXPECT_EQ(played->sets[0].rows[1].condition, LiveCondition::rapid);
}

TEST(StudyLive, SaysWhatCannotBeStudied) {
  LiveModels none = models();
  none.causal.clear();
  const auto modelless = study_live(brief(), rig(), none, no_progress);
  ASSERT_FALSE(modelless);
  EXPECT_EQ(modelless.error().code, ErrorCode::bad_usage);

  LiveModels wrong = models();
  wrong.causal[1].file = tracker::test::tiny_model(kSensors);
  const auto window_as_causal = study_live(brief(), rig(), wrong, no_progress);
  ASSERT_FALSE(window_as_causal);
  EXPECT_EQ(window_as_causal.error().code, ErrorCode::mismatch);

  LiveRequest nobody = brief();
  nobody.performers = 0;
  EXPECT_EQ(study(nobody).error().code, ErrorCode::bad_usage);
  nobody.motions.push_back({virt::test::talking(60), 0});
  EXPECT_EQ(study(nobody).error().code, ErrorCode::bad_usage) << "no face";

  EXPECT_EQ(study(brief({LiveCondition::three_lost})).error().code, ErrorCode::not_found);

  const auto stopped = study_live(brief(), rig(), models(), [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

TEST(LiveMethod, SpreadsOverThePerformersThatHaveIt) {
  LiveMethod method{"m", std::vector<Figures>(3)};
  EXPECT_FALSE(method.over(Measure::pve));
  method.performers[0][0] = 1.0;
  EXPECT_EQ(method.over(Measure::pve)->mean, 1.0);
  EXPECT_EQ(method.over(Measure::pve)->std, 0.0);
  method.performers[2][0] = 3.0;
  EXPECT_EQ(method.over(Measure::pve)->mean, 2.0);
  EXPECT_DOUBLE_EQ(method.over(Measure::pve)->std, std::sqrt(2.0));
  EXPECT_FALSE(method.over(Measure::mse));
}

}  // namespace
}  // namespace mien::lab::live_study_test
