#include "lab/trackers/trackers_study.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "lab/trackers/trackers_report.h"
#include "mien/builtin_face/builtin_face.h"
#include "tests/tracker/tiny_model.h"
#include "tests/virtual/three_sensors.h"

namespace mien::lab::trackers_study_test {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;

const std::vector<std::string> kSensors = {"mentalis", "buccinator_L"};

sensor::Rig rig() {
  sensor::Rig out = virt::test::three_sensors();
  out.faults_toml =
      "mount_rotation_deg = 180\nmount_position_mm = 1\nclock_offset_s = [1, 50]\nradio_delay_min_ms = 1\n"
      "gyro_noise_dps_sqrt_hz = 0.015\n";
  return out;
}

TrackersRequest brief(std::vector<TrackerCondition> conditions, unsigned threads = 1) {
  TrackersRequest request;
  request.conditions = std::move(conditions);
  request.performers = 2;
  request.seconds = 3;
  request.seed = 3;
  request.threads = threads;
  return request;
}

Result<TrackersStudy> study(const TrackersRequest& request, const Progress& progress = no_progress) {
  return study_trackers(request, rig(), tracker::test::tiny_causal_model(kSensors), progress);
}

TEST(TrackerConditions, HaveNamesThatComeBack) {
  for (std::size_t c = 0; c < kTrackerConditionCount; ++c) {
    const auto condition = static_cast<TrackerCondition>(c);
    EXPECT_EQ(parse_tracker_condition(tracker_condition_name(condition)).value(), condition);
  }
  const auto wrong = parse_tracker_condition("eatin");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::not_found);
  EXPECT_THAT(wrong.error().message(), HasSubstr("did you mean eating?"));
  EXPECT_THAT(wrong.error().message(), HasSubstr("turned_away"));
}

void expect_all_methods(const TrackersStudy& done) {
  EXPECT_TRUE(done.modelled);
  for (const TrackersRow& row : done.rows) {
    ASSERT_EQ(row.methods.size(), 1 + kTrackerKindCount) << row.key;
    EXPECT_EQ(row.methods[0].name, kOwnCurves);
    EXPECT_EQ(row.common, 16U) << "OpenSeeFace's";
    EXPECT_NEAR(static_cast<double>(row.frames), 2 * 3 * 60, 40) << row.key;
    for (const TrackerMethod& method : row.methods) {
      ASSERT_EQ(method.performers.size(), 2U);
      EXPECT_GT(method.over(TrackerMeasure::pve_whole)->mean, 0) << row.key << ", " << method.name;
      EXPECT_TRUE(method.over(TrackerMeasure::mse_common)) << row.key << ", " << method.name;
      EXPECT_GE(method.over(TrackerMeasure::gap_share)->mean, 0);
    }
    EXPECT_LT(row.methods[0].over(TrackerMeasure::gap_share)->mean, 1e-9) << "sensors see no faces to lose";
    ASSERT_TRUE(row.moment) << row.key;
    EXPECT_EQ(row.moment->lines.size(), row.methods.size());
    EXPECT_NE(row.moment->worst, kOwnCurves);
    EXPECT_LE(row.moment->above_mm, row.moment->pve_mm);
    EXPECT_EQ(row.find("nobody"), nullptr);
  }
}

void expect_a_page(const TrackersStudy& done) {
  const auto report = trackers_report(done, "a <test>");
  ASSERT_TRUE(report) << report.error().message();
  const std::string html = report->html();
  EXPECT_THAT(html, HasSubstr("Modelled, not measured"));
  EXPECT_THAT(html, HasSubstr("assumed"));
  EXPECT_THAT(html, HasSubstr("a &lt;test&gt;"));
  EXPECT_THAT(html, HasSubstr("webcam (OpenSeeFace)"));
  EXPECT_THAT(html, HasSubstr("jawOpen around its worst moment"));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  const std::vector<TrackerPicture> pictures = {
      {.row = done.rows[0].key, .strip = render::Image(8, 8), .caption = "worst of all"},
      {.row = "another", .strip = render::Image(8, 8), .caption = "of no row"}};
  const std::string pictured = trackers_report(done, "", pictures)->html();
  EXPECT_THAT(pictured, HasSubstr("worst of all"));
  EXPECT_THAT(pictured, Not(HasSubstr("of no row")));
  const measure::Table errors = trackers_table(done);
  EXPECT_EQ(errors.strong_rows.size(), done.rows.size());
  const auto above = std::ranges::find(errors.columns, "above Mien (IMUs)") - errors.columns.begin();
  ASSERT_LT(above, std::ssize(errors.columns));
  for (const auto& row : errors.rows) {
    if (row.size() == 1) continue;
    ASSERT_EQ(row.size(), errors.columns.size());
    const std::string& cell = row[static_cast<std::size_t>(above)];
    if (row[0] == kOwnCurves) {
      EXPECT_EQ(cell, "-");
    } else {
      EXPECT_THAT(cell, MatchesRegex("[+-][0-9.]+ ± [0-9.]+"));
    }
  }
  EXPECT_THAT(html, HasSubstr("mm above that of Mien (IMUs), gaps held"));
  const measure::Table lags = lag_table(done);
  for (const auto& row : lags.rows) EXPECT_TRUE(row.size() == 1 || row.size() == 4);
}

/// The conditions are studied once for everything that is asked of them.
TEST(StudyTrackers, ComparesAllUnderEveryCondition) {
  const std::vector<TrackerCondition> conditions = {TrackerCondition::talking, TrackerCondition::turned_away,
                                                    TrackerCondition::dark, TrackerCondition::eating};
  const auto done = study(brief(conditions));
  ASSERT_TRUE(done) << done.error().message();
  ASSERT_EQ(done->rows.size(), conditions.size());
  expect_all_methods(*done);
  const TrackersRow &talking = done->rows[0], &turned = done->rows[1], &dark = done->rows[2];
  EXPECT_EQ(dark.key, "dark");
  const auto pve = static_cast<std::size_t>(TrackerMeasure::pve_whole);
  for (std::size_t p = 0; p < 2; ++p) {
    const double lit = *talking.methods[0].performers[p][pve];
    EXPECT_NEAR(*dark.methods[0].performers[p][pve], lit, 0.1 * lit) << "no sensor needs light";
    EXPECT_NE(*turned.methods[0].performers[p][pve], lit) << "but they feel a head that turns";
  }
  expect_a_page(*done);

  const auto some = study(brief({TrackerCondition::dark}, 2));
  ASSERT_TRUE(some) << some.error().message();
  for (std::size_t m = 0; m < dark.methods.size(); ++m)
    EXPECT_EQ(some->rows[0].methods[m].performers, dark.methods[m].performers)
        << "neither threads nor other rows matter";
}

TEST(StudyTrackers, SaysWhatCannotBeStudied) {
  TrackersRequest nobody = brief({});
  nobody.performers = 0;
  EXPECT_EQ(study(nobody).error().code, ErrorCode::bad_usage);
  TrackersRequest blink = brief({});
  blink.seconds = 1;
  EXPECT_EQ(study(blink).error().code, ErrorCode::bad_usage);
  const auto window = study_trackers(brief({}), rig(), tracker::test::tiny_model(kSensors), no_progress);
  ASSERT_FALSE(window);
  EXPECT_EQ(window.error().code, ErrorCode::mismatch);
  const auto stopped =
      study(brief({TrackerCondition::talking}), [](double, std::string_view) { return false; });
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::cancelled);
}

TEST(TrackerPictures, ShowTheWorstMoment) {
  TrackersRow row;
  row.key = row.title = "talking";
  const face::Face face = builtin_face::make_builtin();
  const auto none = tracker_picture(face, row);
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->strip) << "a row without a moment";

  TrackerMoment& moment = row.moment.emplace();
  moment.worst_s = 0.5;
  moment.time_s = {0, 0.5, 1};
  moment.truth.resize(3);
  moment.lines.push_back(
      {"phone \xC3\xBC", ToldShapes().set(), std::vector<face::BlendshapeWeights>(3), {true, false, true}});
  const auto picture = tracker_picture(face, row);
  ASSERT_TRUE(picture) << picture.error().message();
  ASSERT_TRUE(picture->strip);
  EXPECT_GT(picture->strip->width, 3 * 160);
}

TEST(RecordedTrackers, HaveAPageWithoutModels) {
  TrackersStudy study;
  TrackersRow& row = study.rows.emplace_back();
  row.key = "recording";
  row.title = "take.mien";
  TrackerMethod& method = row.methods.emplace_back();
  method.name = "phone";
  method.performers.emplace_back();
  method.performers[0][static_cast<std::size_t>(TrackerMeasure::pve_whole)] = 1.25;
  method.performers[0][static_cast<std::size_t>(TrackerMeasure::gap_share)] = 0.5;
  const std::string html = trackers_report(study, "")->html();
  EXPECT_THAT(html, HasSubstr("1.25 mm"));
  EXPECT_THAT(html, HasSubstr("50.0 % of the frames in gaps"));
  EXPECT_THAT(html, Not(HasSubstr("Modelled, not measured")));
  EXPECT_THAT(html, Not(HasSubstr("its offset taken")));

  study.shared_clock = false;
  EXPECT_THAT(trackers_report(study, "")->html(),
              HasSubstr("vertex error, gaps held, all shapes, its offset taken out"));
  method.performers[0][static_cast<std::size_t>(TrackerMeasure::pve_whole)].reset();
  study.offset_unknown = {"phone"};
  const std::string unknown = trackers_report(study, "")->html();
  EXPECT_THAT(unknown, HasSubstr("phone: how much earlier or later it began than the truth was not found"));
  EXPECT_THAT(unknown, HasSubstr("its offset was not found; 50.0 %"));
  EXPECT_THAT(unknown, Not(HasSubstr("1.25 mm")));
}

}  // namespace
}  // namespace mien::lab::trackers_study_test
