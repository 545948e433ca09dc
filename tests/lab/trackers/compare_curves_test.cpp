#include "lab/trackers/compare_curves.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "lab/trackers/tracker_curves.h"
#include "lab/trackers/trackers_report.h"
#include "mien/builtin_face/builtin_face.h"
#include "mien/core/random.h"

namespace mien::lab::compare_curves_test {
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
  const auto moment = worst_moment(*compared);
  ASSERT_TRUE(moment);
  EXPECT_GT(moment->time_s, 4);
  EXPECT_LT(moment->time_s, 6.5);
  EXPECT_NEAR(compared->time_s[moment->begin], moment->time_s - 2.5, 1.0 / 60);
  EXPECT_NEAR(compared->time_s[moment->end - 1], moment->time_s + 2.5, 1.0 / 60);
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

/// A lag is told as surely as is said: over many noises its error is what its standard errors are.
TEST(CompareCurves, TellsHowSureALagIs) {
  constexpr double kLate_s = 0.08, kNoise = 0.15;
  constexpr std::size_t kTrackers = 8;
  const TrackerCurves truth = told_by("truth", 0, 12, 60);
  std::vector<TrackerCurves> trackers;
  for (std::size_t i = 0; i < kTrackers; ++i) {
    Random random = Random(1).fork("noise", i);
    trackers.push_back(told_by("noisy " + std::to_string(i), 0, 12, 30, kLate_s));
    trackers.back().told = ToldShapes().set(kJaw).set(kSmile);
    for (TrackerRow& row : trackers.back().rows)
      for (const std::size_t k : {kJaw, kSmile})
        (*row.weights)[k] += static_cast<float>(random.normal(0, kNoise));
  }
  const auto compared = compare_curves(meter(), truth, trackers, {.search_s = 0.25});
  ASSERT_TRUE(compared) << compared.error().message();
  double error = 0, said = 0;  // Mean squares.
  for (const CurveScore& score : compared->scores) {
    ASSERT_TRUE(score.lag) << score.name;
    const double off_s = score.lag->lag_s - kLate_s;
    // Six parts make a standard error of few degrees of freedom, so single ones go far out.
    EXPECT_LT(std::abs(off_s), 6 * score.lag->sigma_s) << score.name;
    error += off_s * off_s / kTrackers;
    said += score.lag->sigma_s * score.lag->sigma_s / kTrackers;
  }
  // Of eight the ratio scatters by a third; the mean is 0.7, so the jackknife tells somewhat too much.
  EXPECT_GT(std::sqrt(error / said), 0.25);
  EXPECT_LT(std::sqrt(error / said), 1.7);
  EXPECT_LT(std::sqrt(said), 0.01) << "less than a frame";
}

/// Rows of truth and trackers are equally far apart: shifts between them, where noise is smoother, agree no
/// better than shifts on them.
TEST(CompareCurves, PrefersNoLagBetweenRows) {
  constexpr double kNoise = 0.15;
  constexpr std::uint64_t kTrackers = 6;
  for (const double rate_hz : {25, 30, 50}) {
    const auto noisy = [&](const std::string& name, std::uint64_t number) {
      TrackerCurves out = told_by(name, 0, 24, rate_hz);
      out.told = ToldShapes().set(kJaw).set(kSmile);
      Random random = Random(2).fork("noise", number);
      for (TrackerRow& row : out.rows)
        for (const std::size_t k : {kJaw, kSmile})
          (*row.weights)[k] += static_cast<float>(random.normal(0, kNoise));
      return out;
    };
    std::vector<TrackerCurves> trackers;
    for (std::uint64_t i = 0; i < kTrackers; ++i)
      trackers.push_back(noisy("tracker " + std::to_string(i), i));
    const auto compared = compare_curves(meter(), noisy("truth", kTrackers), trackers, {.search_s = 0.25});
    ASSERT_TRUE(compared) << compared.error().message();
    double squares = 0;
    for (const CurveScore& score : compared->scores) {
      ASSERT_TRUE(score.lag) << score.name;
      squares += score.lag->lag_s * score.lag->lag_s / kTrackers;
    }
    EXPECT_LT(std::sqrt(squares), 0.012) << rate_hz;
  }
}

/// Told too small by a fifth, by one who began with the truth and by one who began 0.3 s before.
std::vector<TrackerCurves> told_small() {
  std::vector<TrackerCurves> out = {told_by("with it", 0, 6, 60), told_by("before it", 0, 6.3, 60, 0.3)};
  for (TrackerCurves& curves : out)
    for (TrackerRow& row : curves.rows)
      for (float& weight : row.weights->values) weight *= 0.8F;
  return out;
}

TEST(CompareCurves, HoldsNobodyToWhenHeBeganToRecord) {
  const TrackerCurves truth = told_by("truth", 0, 6, 60);
  const auto apart = compare_curves(meter(), truth, told_small(), {.shared_clock = false});
  ASSERT_TRUE(apart) << apart.error().message();
  EXPECT_FALSE(apart->shared_clock);
  const CurveScore &with = apart->scores[0], &before = apart->scores[1];
  EXPECT_NEAR(with.lag->lag_s, 0, 1e-3);
  EXPECT_NEAR(before.lag->lag_s, 0.3, 1e-3);
  // A lag that is a millisecond wrong is an error of 0.003 beside one of 0.1.
  EXPECT_NEAR(before.held.pve_mm, with.held.pve_mm, 0.02 * with.held.pve_mm);
  EXPECT_NEAR(before.pve_whole_mm, with.pve_whole_mm, 0.02 * with.pve_whole_mm);
  EXPECT_NEAR(before.mse_whole, with.mse_whole, 0.04 * with.mse_whole);
  EXPECT_LT(before.gap_share, 1e-9) << "time beyond a recording is no gap";
  EXPECT_GT(before.as_told->pve_mm, 2 * with.as_told->pve_mm) << "this has it still";
  EXPECT_FALSE(before.offset_unknown);

  const auto shared = compare_curves(meter(), truth, told_small());
  ASSERT_TRUE(shared) << shared.error().message();
  EXPECT_GT(shared->scores[1].held.pve_mm, 2 * shared->scores[0].held.pve_mm);
  EXPECT_GT(shared->scores[1].pve_whole_mm, 2 * shared->scores[0].pve_whole_mm);
  EXPECT_DOUBLE_EQ(shared->scores[1].held.pve_mm, shared->scores[1].as_told->pve_mm) << "as its time says";
}

TEST(CompareCurves, LeavesOutWhatHasAnUnknownOffsetInIt) {
  const TrackerCurves truth = told_by("truth", 0, 6, 60);
  const auto compared =
      compare_curves(meter(), truth, told_small(), {.search_s = 0.2, .shared_clock = false});
  ASSERT_TRUE(compared) << compared.error().message();
  EXPECT_TRUE(compared->scores[1].offset_unknown);
  const Json with = json_of(compared->scores[0], tracker_columns()),
             before = json_of(compared->scores[1], tracker_columns());
  EXPECT_FALSE(with.at("pve_whole_mm").is_null());
  for (const char* name : {"pve_held_mm", "pve_whole_mm", "mse_common", "mse_whole"})
    EXPECT_TRUE(before.at(name).is_null()) << name;
  EXPECT_FALSE(before.at("pve_seen_mm").is_null());
  const auto moment = worst_moment(*compared);
  ASSERT_TRUE(moment);
  EXPECT_EQ(moment->tracker, "with it") << "the other is worse by its offset alone";

  const std::vector<TrackerCurves> alone = {told_small()[1]};
  const auto nobody = compare_curves(meter(), truth, alone, {.search_s = 0.2, .shared_clock = false});
  ASSERT_TRUE(nobody) << nobody.error().message();
  EXPECT_FALSE(worst_moment(*nobody));
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

}  // namespace
}  // namespace mien::lab::compare_curves_test
