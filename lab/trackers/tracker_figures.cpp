#include "lab/trackers/tracker_figures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/interval.h"
#include "mien/core/median.h"

namespace mien::lab {
namespace {

constexpr std::array<std::string_view, kTrackerMeasureCount> kTrackerMeasureNames = {
    "pve_seen_mm",       "pve_without_lag_mm", "pve_held_mm",     "pve_whole_mm", "pve_face_held_mm",
    "landmarks_held_mm", "mse_seen",           "mse_without_lag", "mse_held",     "mse_common",
    "mse_whole",         "gap_share",          "lag_ms",          "lag_sigma_ms"};
/// Seconds over which the worst moment is sought, and that are kept each way.
constexpr double kMoment_s = 1, kMomentEachWay_s = 2.5;

std::vector<double> values_of(const std::vector<TrackerFigures>& performers, TrackerMeasure measure) {
  std::vector<double> out;
  for (const TrackerFigures& figures : performers)
    if (const auto& value = figures[static_cast<std::size_t>(measure)]) out.push_back(*value);
  return out;
}

double frame_rate(const std::vector<double>& time_s) {
  if (time_s.size() < 2) return 60;
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  return 1 / upper_median(std::move(steps));
}

}  // namespace

std::string_view tracker_measure_name(TrackerMeasure measure) {
  return kTrackerMeasureNames[static_cast<std::size_t>(measure)];
}

TrackerFigures figures_of(const CurveScore& score) {
  TrackerFigures out;
  const auto put = [&out](TrackerMeasure measure, std::optional<double> value) {
    out[static_cast<std::size_t>(measure)] = value;
  };
  if (score.as_told) {
    put(TrackerMeasure::pve_seen, score.as_told->pve_mm);
    put(TrackerMeasure::mse_seen, score.as_told->mse_told);
  }
  if (score.without_lag) {
    put(TrackerMeasure::pve_without_lag, score.without_lag->pve_mm);
    put(TrackerMeasure::mse_without_lag, score.without_lag->mse_told);
  }
  if (!score.offset_unknown) {
    put(TrackerMeasure::pve_held, score.held.pve_mm);
    put(TrackerMeasure::pve_whole, score.pve_whole_mm);
    put(TrackerMeasure::pve_face_held, score.held.pve_face_mm);
    put(TrackerMeasure::landmarks_held, score.held.landmarks_mm);
    put(TrackerMeasure::mse_held, score.held.mse_told);
    put(TrackerMeasure::mse_common, score.held.mse_common);
    put(TrackerMeasure::mse_whole, score.mse_whole);
  }
  put(TrackerMeasure::gap_share, score.gap_share);
  if (score.lag) {
    put(TrackerMeasure::lag, 1e3 * score.lag->lag_s);
    put(TrackerMeasure::lag_sigma, 1e3 * score.lag->sigma_s);
  }
  return out;
}

std::optional<TrackerMean> mean_over_performers(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const Interval of = mean_interval({values});
  TrackerMean out{.mean = of.mean, .performers = values.size(), .interval = {}};
  if (values.size() > 1) out.interval = {of.low, of.high};
  return out;
}

std::optional<TrackerMean> TrackerMethod::over(TrackerMeasure measure) const {
  return mean_over_performers(values_of(performers, measure));
}

std::optional<TrackerMean> TrackerMethod::above(const TrackerMethod& other, TrackerMeasure measure) const {
  std::vector<double> differences;
  for (std::size_t p = 0; p < std::min(performers.size(), other.performers.size()); ++p) {
    const auto& own = performers[p][static_cast<std::size_t>(measure)];
    const auto& its = other.performers[p][static_cast<std::size_t>(measure)];
    if (own && its) differences.push_back(*own - *its);
  }
  return mean_over_performers(differences);
}

TrackerMoment worst_moment(const CurveComparison& comparison, std::string_view reference) {
  TrackerMoment out;
  const std::vector<double>& time_s = comparison.time_s;
  if (time_s.empty()) return out;
  const auto beside = std::ranges::find(comparison.scores, reference, &CurveScore::name);
  for (const CurveScore& score : comparison.scores) {
    if (score.offset_unknown) continue;
    if (beside != comparison.scores.end() && score.name == beside->name && comparison.scores.size() > 1)
      continue;
    // A window that slides over the time: what comes in at its end leaves at its beginning.
    double own = 0, its = 0;
    std::size_t begin = 0;
    for (std::size_t end = 0; end < time_s.size(); ++end) {
      own += score.pve_mm[end];
      if (beside != comparison.scores.end()) its += beside->pve_mm[end];
      for (; time_s[end] - time_s[begin] > kMoment_s; ++begin) {
        own -= score.pve_mm[begin];
        if (beside != comparison.scores.end()) its -= beside->pve_mm[begin];
      }
      const auto count = static_cast<double>(end - begin + 1);
      const bool whole = time_s[end] - time_s[begin] > 0.9 * kMoment_s || end + 1 == time_s.size();
      if (!whole || (!out.worst.empty() && (own - its) / count <= out.above_mm)) continue;
      out.above_mm = (own - its) / count;
      out.worst_s = 0.5 * (time_s[begin] + time_s[end]);
      out.pve_mm = own / count;
      out.worst = score.name;
    }
  }
  if (out.worst.empty()) return out;
  std::vector<std::size_t> kept;
  for (std::size_t f = 0; f < time_s.size(); ++f)
    if (std::abs(time_s[f] - out.worst_s) <= kMomentEachWay_s) kept.push_back(f);
  for (const std::size_t f : kept) {
    out.time_s.push_back(time_s[f]);
    out.truth.push_back(comparison.truth[f]);
  }
  for (const CurveScore& score : comparison.scores) {
    TrackerMoment::Line& line = out.lines.emplace_back();
    line.name = score.name;
    line.told = score.told_shapes;
    for (const std::size_t f : kept) {
      line.shown.push_back(score.shown[f]);
      line.saw.push_back(score.saw[f]);
    }
  }
  return out;
}

const TrackerMethod* TrackersRow::find(std::string_view method) const {
  const auto found = std::ranges::find(methods, method, &TrackerMethod::name);
  return found == methods.end() ? nullptr : &*found;
}

void TrackersRow::keep_worst(TrackerMoment other) {
  if (other.worst.empty() || (moment && other.above_mm <= moment->above_mm)) return;
  moment = std::move(other);
}

TrackersStudy study_of(const CurveComparison& comparison, std::string title) {
  TrackersStudy out;
  out.shared_clock = comparison.shared_clock;
  for (const CurveScore& score : comparison.scores)
    if (score.offset_unknown) out.offset_unknown.push_back(score.name);
  TrackersRow& row = out.rows.emplace_back();
  row.key = "recording";
  row.title = std::move(title);
  row.frames = comparison.time_s.size();
  row.frames_hz = frame_rate(comparison.time_s);
  row.common = comparison.common.count();
  for (const CurveScore& score : comparison.scores)
    row.methods.push_back({score.name, score.told_shapes.count(), {figures_of(score)}});
  row.keep_worst(worst_moment(comparison, {}));
  return out;
}

}  // namespace mien::lab
