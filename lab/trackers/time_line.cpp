#include "lab/trackers/time_line.h"

#include <algorithm>
#include <span>

#include "mien/core/monotone_cubic.h"

namespace mien::lab {

TimeLine::TimeLine(const TrackerCurves& curves) {
  const double period_s = curves.period_s();
  reach_s_ = 0.5 * period_s;
  const double longest_s = kGapPeriods * period_s;
  std::size_t run = 0;
  bool lost = false;
  double last_s = curves.first_s();
  for (const TrackerRow& row : curves.rows) {
    // A little more than three periods is three: times are rounded to milliseconds.
    if (row.time_s - last_s > longest_s + 0.1 * period_s) lost = true;
    last_s = row.time_s;
    if (!row.weights) {
      lost = true;
      continue;
    }
    if (lost && !time_s_.empty()) ++run;
    lost = false;
    time_s_.push_back(row.time_s);
    value_.push_back(*row.weights);
    run_.push_back(run);
  }
  slope_.resize(value_.size());
  std::vector<float> value, slope;
  for (std::size_t begin = 0, end = 0; begin < run_.size(); begin = end) {
    while (end < run_.size() && run_[end] == run_[begin]) ++end;
    const std::size_t count = end - begin;
    value.resize(count);
    slope.resize(count);
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (!curves.told[k]) continue;
      for (std::size_t i = 0; i < count; ++i) value[i] = value_[begin + i][k];
      monotone_slopes(std::span(time_s_).subspan(begin, count), value, slope);
      for (std::size_t i = 0; i < count; ++i) slope_[begin + i][k] = slope[i];
    }
  }
}

std::optional<face::BlendshapeWeights> TimeLine::at(double time_s) const {
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(time_s_, time_s) - time_s_.begin());
  const bool has_below = above > 0, has_above = above < time_s_.size();
  if (has_below && has_above && run_[above - 1] == run_[above]) {
    const std::size_t below = above - 1;
    face::BlendshapeWeights out;
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      out[k] = hermite(time_s_[below], value_[below][k], slope_[below][k], time_s_[above], value_[above][k],
                       slope_[above][k], time_s);
    return out;
  }
  if (has_below && time_s - time_s_[above - 1] <= reach_s_) return value_[above - 1];
  if (has_above && time_s_[above] - time_s <= reach_s_) return value_[above];
  return std::nullopt;
}

face::BlendshapeWeights TimeLine::held_at(double time_s) const {
  if (const auto seen = at(time_s)) return *seen;
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(time_s_, time_s) - time_s_.begin());
  return above > 0 ? value_[above - 1] : face::BlendshapeWeights{};
}

}  // namespace mien::lab
