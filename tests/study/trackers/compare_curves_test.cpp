#include "mien/study/trackers/compare_curves.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "mien/builtin_face/builtin_face.h"
#include "mien/study/trackers/time_line.h"
#include "mien/study/trackers/tracker_figures.h"

namespace mien::study::compare_curves_test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kJaw = face::shape("jawOpen"), kSmile = face::shape("mouthSmile_L");

const measure::Meter& meter() {
  static const measure::Meter made(builtin_face::make_builtin());
  return made;
}

/// A face that never does the same twice: two slow tones that have no common period.
face::BlendshapeWeights face_at(double time_s) {
  constexpr double kTurn = 2 * std::numbers::pi;
  face::BlendshapeWeights out;
  out[kJaw] =
      static_cast<float>(0.5 + 0.3 * std::sin(kTurn * 1.3 * time_s) + 0.1 * std::sin(kTurn * 0.37 * time_s));
  out[kSmile] = static_cast<float>(0.4 + 0.3 * std::sin(kTurn * 0.61 * time_s));
  return out;
}

TrackerCurves told_by(std::string name, double from_s, double to_s, double rate_hz, double late_s = 0) {
  TrackerCurves out{.name = std::move(name), .rows = {}, .told = {}, .warnings = {}};
  out.told.set();
  const auto count = static_cast<int>((to_s - from_s) * rate_hz);
  for (int i = 0; i <= count; ++i) {
    const double time_s = from_s + i / rate_hz;
    out.rows.push_back({time_s, face_at(time_s - late_s)});
  }
  return out;
}

TEST(TimeLine, GoesThroughRowsAndNeverAcrossAGap) {
  TrackerCurves curves = told_by("x", 0, 1, 30);
  curves.rows[10].weights.reset();
  curves.rows.erase(curves.rows.begin() + 15);                            // One frame that was dropped.
  curves.rows.erase(curves.rows.begin() + 20, curves.rows.begin() + 25);  // Half a dozen.
  const TimeLine line(curves);
  EXPECT_NEAR((*line.at(5 / 30.0))[kJaw], face_at(5 / 30.0)[kJaw], 1e-6);
  EXPECT_NEAR((*line.at(5.5 / 30.0))[kJaw], face_at(5.5 / 30.0)[kJaw], 0.02);
  EXPECT_FALSE(line.at(10 / 30.0));
  EXPECT_TRUE(line.at(9.4 / 30.0)) << "half a period belongs to the row before";
  EXPECT_FALSE(line.at(9.6 / 30.0));
  EXPECT_TRUE(line.at(15 / 30.0)) << "one dropped frame is no gap";
  EXPECT_FALSE(line.at(23 / 30.0));
  EXPECT_FALSE(line.at(-0.1));
  EXPECT_EQ(line.held_at(-0.1), face::BlendshapeWeights{}) << "neutral before all";
  EXPECT_EQ(line.held_at(10 / 30.0), *curves.rows[9].weights);
}

TEST(CompareCurves, TellsLagFromError) {
  const TrackerCurves truth = told_by("truth", 0, 12, 60);
  const std::vector<TrackerCurves> trackers = {told_by("same", 0, 12, 60), told_by("late", 0, 12, 30, 0.08),
                                               told_by("early", 0, 12, 24, -0.03)};
  const auto compared = compare_curves(meter(), truth, trackers);
  ASSERT_TRUE(compared) << compared.error().message();
  ASSERT_EQ(compared->scores.size(), 3U);
  const CurveScore& same = compared->scores[0];
  EXPECT_LT(same.as_told->pve_mm, 1e-4);
  EXPECT_NEAR(same.lag->lag_s, 0, 1e-3);
  const CurveScore& late = compared->scores[1];
  ASSERT_TRUE(late.lag);
  EXPECT_NEAR(late.lag->lag_s, 0.08, 0.004);
  EXPECT_LT(late.lag->sigma_s, 0.01);
  EXPECT_GT(late.lag->agreement, 0.99);
  EXPECT_LT(late.without_lag->pve_mm, 0.25 * late.as_told->pve_mm);
  EXPECT_LT(late.without_lag->mse_told, 0.1 * late.as_told->mse_told);
  EXPECT_NEAR(compared->scores[2].lag->lag_s, -0.03, 0.004);
  EXPECT_EQ(late.gap_share, 0);
}

TEST(CompareCurves, CountsGapsAsGaps) {
  const TrackerCurves truth = told_by("truth", 0, 10, 60);
  TrackerCurves gappy = told_by("gappy", 0, 10, 60);
  for (TrackerRow& row : gappy.rows)
    if (row.time_s > 4 && row.time_s < 6) row.weights.reset();
  TrackerCurves silent = told_by("silent", 0, 10, 60);
  std::erase_if(silent.rows, [](const TrackerRow& row) { return row.time_s > 4 && row.time_s < 6; });
  const std::vector<TrackerCurves> trackers = {gappy, silent};
  const auto compared = compare_curves(meter(), truth, trackers);
  ASSERT_TRUE(compared) << compared.error().message();
  for (const CurveScore& score : compared->scores) {
    EXPECT_NEAR(score.gap_share, 0.2, 0.005) << score.name;
    EXPECT_LT(score.as_told->pve_mm, 1e-4) << "what it saw is right";
    EXPECT_GT(score.held.pve_mm, 0.02) << "what an avatar shows is not";
    EXPECT_EQ(score.saw.size(), score.shown.size());
  }
  const TrackerMoment moment = worst_moment(*compared, {});
  EXPECT_GT(moment.worst_s, 4);
  EXPECT_LT(moment.worst_s, 6.5);
  EXPECT_EQ(moment.lines.size(), 2U);
  EXPECT_EQ(moment.lines[0].shown.size(), moment.time_s.size());
}

TEST(CompareCurves, HoldsNobodyToWhatHeDoesNotTell) {
  const TrackerCurves truth = told_by("truth", 0, 5, 60);
  std::vector<TrackerCurves> trackers = {told_by("jaw", 0, 5, 60), told_by("all", 0, 5, 60)};
  trackers[0].told.reset();
  trackers[0].told.set(kJaw);
  for (TrackerRow& row : trackers[0].rows) (*row.weights)[kSmile] = 0;
  const auto compared = compare_curves(meter(), truth, trackers);
  ASSERT_TRUE(compared) << compared.error().message();
  const CurveScore& jaw = compared->scores[0];
  EXPECT_EQ(jaw.told_shapes.count(), 1U);
  EXPECT_LT(jaw.held.pve_mm, 1e-4);
  EXPECT_LT(jaw.held.mse_told, 1e-9);
  EXPECT_GT(jaw.pve_whole_mm, 0.02) << "an avatar that has nothing else";
  EXPECT_GT(jaw.mse_whole, 1e-3);
  EXPECT_EQ(compared->common.count(), 1U);
}

TEST(CompareCurves, TellsNoLagOfAFaceThatDoesNotMove) {
  TrackerCurves truth = told_by("truth", 0, 5, 60);
  for (TrackerRow& row : truth.rows) row.weights = face_at(0);
  const std::vector<TrackerCurves> trackers = {told_by("x", 0, 5, 60)};
  const auto compared = compare_curves(meter(), truth, trackers);
  ASSERT_TRUE(compared) << compared.error().message();
  EXPECT_FALSE(compared->scores[0].lag);
  EXPECT_FALSE(compared->scores[0].without_lag);
  EXPECT_TRUE(compared->scores[0].as_told);
}

TEST(CompareCurves, TellsNoLagBeyondWhatWasTried) {
  const TrackerCurves truth = told_by("truth", 0, 12, 60);
  const std::vector<TrackerCurves> trackers = {told_by("x", 0, 12, 60, 0.3)};
  const auto near = compare_curves(meter(), truth, trackers, {.search_s = 0.2});
  ASSERT_TRUE(near) << near.error().message();
  EXPECT_FALSE(near->scores[0].lag);
  const auto far = compare_curves(meter(), truth, trackers, {.search_s = 0.5});
  ASSERT_TRUE(far->scores[0].lag);
  EXPECT_NEAR(far->scores[0].lag->lag_s, 0.3, 0.004);
}

TEST(CompareCurves, SaysWhatCannotBeCompared) {
  const TrackerCurves truth = told_by("the truth", 0, 5, 60);
  const auto refused = [&](const std::vector<TrackerCurves>& trackers, ErrorCode code,
                           const std::vector<std::string>& words, CompareSettings settings = {}) {
    const auto compared = compare_curves(meter(), truth, trackers, settings);
    ASSERT_FALSE(compared);
    EXPECT_EQ(compared.error().code, code);
    for (const std::string& word : words) EXPECT_THAT(compared.error().message(), HasSubstr(word));
  };
  refused({}, ErrorCode::bad_usage, {"no tracker"});
  refused({told_by("x", 100, 105, 30)}, ErrorCode::mismatch,
          {"x is from 100.000 to 105.000 s", "the truth is from 0.000 to 5.000 s"});
  refused({told_by("a", 0, 2, 60), told_by("b", 2.5, 5, 60)}, ErrorCode::mismatch,
          {"a is from 0.000 to 2.000 s", "b is from 2.500 to 5.000 s"});
  refused({told_by("x", 0, 5, 60), told_by("x", 0, 5, 30)}, ErrorCode::bad_usage, {"one name"});
  refused({told_by("x", 0, 5, 60)}, ErrorCode::bad_usage, {"sought"}, {.search_s = 6});
  TrackerCurves nothing = told_by("x", 0, 5, 60);
  nothing.told.reset();
  refused({nothing}, ErrorCode::mismatch, {"no shape"});

  TrackerCurves faceless = truth;
  for (TrackerRow& row : faceless.rows) row.weights.reset();
  const std::vector<TrackerCurves> one = {told_by("x", 0, 5, 60)};
  EXPECT_EQ(compare_curves(meter(), faceless, one).error().code, ErrorCode::not_found);
}

TEST(MeanOverPerformers, HasAnIntervalOfTwoOrMore) {
  EXPECT_FALSE(mean_over_performers({}));
  EXPECT_FALSE(mean_over_performers({3})->interval);
  const std::vector<double> values = {1, 2, 3, 4, 5};
  const auto mean = mean_over_performers(values);
  EXPECT_DOUBLE_EQ(mean->mean, 3);
  ASSERT_TRUE(mean->interval);
  EXPECT_NEAR((*mean->interval)[1] - 3, 2.776 * std::sqrt(2.5 / 5), 0.01);
  EXPECT_NEAR(3 - (*mean->interval)[0], 2.776 * std::sqrt(2.5 / 5), 0.01);
}

TEST(TrackerMethod, IsHeldAgainstAnotherPerformerByPerformer) {
  TrackerMethod a{"a", 1, std::vector<TrackerFigures>(3)}, b = a;
  const auto pve = static_cast<std::size_t>(TrackerMeasure::pve_whole);
  a.performers[0][pve] = 3;
  b.performers[0][pve] = 1;
  a.performers[2][pve] = 6;
  b.performers[2][pve] = 4;
  b.performers[1][pve] = 100;
  EXPECT_DOUBLE_EQ(a.above(b, TrackerMeasure::pve_whole)->mean, 2) << "where both have it";
  EXPECT_FALSE(a.above(b, TrackerMeasure::lag));
}

}  // namespace
}  // namespace mien::study::compare_curves_test
