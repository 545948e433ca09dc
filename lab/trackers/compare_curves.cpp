#include "lab/trackers/compare_curves.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "lab/columns.h"
#include "lab/trackers/tracker_curves.h"
#include "mien/core/time.h"

namespace mien::lab {
namespace {

constexpr double kWidestSearch_s = 5;
constexpr double kLeastOverlap_s = 1;
/// Shifts are tried a frame of 60 apart; between them a parabola is laid.
constexpr double kShiftStep_s = 1 / kFrameRateHz;
/// Parts of the time that are left out in turn.
constexpr std::size_t kLagBlocks = 6;

float held_to_unit(float weight) {
  return std::clamp(weight, 0.0F, 1.0F);
}

/// What one shape's truth and estimate have in common, over some frames.
struct PairSums {
  double a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  PairSums& operator+=(const PairSums& other) {
    a += other.a;
    b += other.b;
    aa += other.aa;
    bb += other.bb;
    ab += other.ab;
    return *this;
  }
};

/// The same of all told shapes, at one shift.
struct ShiftSums {
  double frames = 0;
  std::vector<PairSums> shapes;

  void add(const ShiftSums& other) {
    if (shapes.empty()) shapes.resize(other.shapes.size());
    frames += other.frames;
    for (std::size_t k = 0; k < shapes.size(); ++k) shapes[k] += other.shapes[k];
  }
  /// Variances and covariance summed over shapes.
  [[nodiscard]] std::array<double, 3> moments() const {
    std::array<double, 3> out{};
    if (frames < 1) return out;
    for (const PairSums& s : shapes) {
      out[0] += s.aa / frames - (s.a / frames) * (s.a / frames);
      out[1] += s.bb / frames - (s.b / frames) * (s.b / frames);
      out[2] += s.ab / frames - (s.a / frames) * (s.b / frames);
    }
    return out;
  }
  [[nodiscard]] double agreement() const {
    const auto [truth, estimate, both] = moments();
    return truth > 0 && estimate > 0 ? both / std::sqrt(truth * estimate) : 0;
  }
};

/// By blocks of time, then by shifts.
using LagTable = std::array<std::vector<ShiftSums>, kLagBlocks>;

/// The told shapes that both sides have.
std::vector<std::size_t> indices_of(const ToldShapes& told) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (told[k]) out.push_back(k);
  return out;
}

/// The truth where lags are sought: its own frames, and between them no further than a shift apart. Of a
/// truth and a tracker whose rows are equally far apart, all would else be compared on rows by one shift and
/// between rows, where noise is smoother and all agrees better, by the next.
struct TruthForLags {
  std::vector<double> time_s;
  std::vector<face::BlendshapeWeights> truth;
};
TruthForLags truth_for_lags(const CurveComparison& comparison, const TimeLine& truth) {
  TruthForLags out;
  for (std::size_t f = 0; f < comparison.time_s.size(); ++f) {
    const double time_s = comparison.time_s[f];
    out.time_s.push_back(time_s);
    out.truth.push_back(comparison.truth[f]);
    if (f + 1 == comparison.time_s.size()) break;
    const double step_s = comparison.time_s[f + 1] - time_s;
    // A little more than a shift is one: times are rounded to milliseconds.
    const auto parts = static_cast<int>(std::ceil(std::min(1.0, step_s) / kShiftStep_s - 0.1));
    for (int i = 1; i < parts; ++i) {
      const double between_s = time_s + step_s * i / parts;
      const auto told = truth.at(between_s);
      if (!told) continue;
      out.time_s.push_back(between_s);
      out.truth.push_back(*told);
    }
  }
  return out;
}

/// Seeks the lag of one tracker.
class LagSearch {
 public:
  LagSearch(const TruthForLags& comparison, const TimeLine& line, const ToldShapes& told, double search_s)
      : each_way_(static_cast<std::ptrdiff_t>(std::llround(search_s / kShiftStep_s))) {
    const std::vector<std::size_t> shapes = indices_of(told);
    const std::size_t shifts = static_cast<std::size_t>(2 * each_way_ + 1);
    for (auto& block : table_) block.assign(shifts, ShiftSums{0, std::vector<PairSums>(shapes.size())});
    const std::size_t frames = comparison.time_s.size();
    for (std::size_t f = 0; f < frames; ++f) {
      std::vector<ShiftSums>& block = table_[f * kLagBlocks / frames];
      for (std::size_t s = 0; s < shifts; ++s) {
        const auto estimate = line.at(comparison.time_s[f] + shift_s(static_cast<double>(s)));
        if (!estimate) continue;
        block[s].frames += 1;
        for (std::size_t i = 0; i < shapes.size(); ++i) {
          const double a = held_to_unit(comparison.truth[f][shapes[i]]);
          const double b = held_to_unit((*estimate)[shapes[i]]);
          block[s].shapes[i] += {a, b, a * a, b * b, a * b};
        }
      }
    }
    told_ = static_cast<double>(shapes.size());
    frame_s_ = frames > 1
                   ? (comparison.time_s.back() - comparison.time_s.front()) / static_cast<double>(frames - 1)
                   : 0;
  }

  [[nodiscard]] std::optional<TrackerLag> find() const {
    const auto whole = best(kLagBlocks);
    if (!whole) return std::nullopt;
    TrackerLag out = *whole;
    std::vector<double> without;
    for (std::size_t left_out = 0; left_out < kLagBlocks; ++left_out)
      if (const auto part = best(left_out)) without.push_back(part->lag_s);
    // Where a part does not let itself be left out, nothing is known of how sure the rest is.
    if (without.size() < kLagBlocks) return std::nullopt;
    double mean = 0, squares = 0;
    for (const double lag_s : without) mean += lag_s / static_cast<double>(without.size());
    for (const double lag_s : without) squares += (lag_s - mean) * (lag_s - mean);
    out.sigma_s = std::sqrt(squares * static_cast<double>(kLagBlocks - 1) / static_cast<double>(kLagBlocks));
    return out;
  }

 private:
  [[nodiscard]] double shift_s(double index) const {
    return (index - static_cast<double>(each_way_)) * kShiftStep_s;
  }

  /// From all blocks but one; kLagBlocks: from all.
  [[nodiscard]] std::optional<TrackerLag> best(std::size_t left_out) const {
    const std::size_t shifts = table_[0].size();
    std::vector<double> agreement(shifts, -1);
    std::vector<ShiftSums> sums(shifts);
    for (std::size_t s = 0; s < shifts; ++s) {
      for (std::size_t b = 0; b < kLagBlocks; ++b)
        if (b != left_out) sums[s].add(table_[b][s]);
      if (sums[s].frames * frame_s_ >= kLagLeast_s) agreement[s] = sums[s].agreement();
    }
    const auto top = static_cast<std::size_t>(std::ranges::max_element(agreement) - agreement.begin());
    // Where it is best at the end of what was tried, it would be better beyond.
    if (top == 0 || top + 1 == shifts || agreement[top] < kLagLeastAgreement) return std::nullopt;
    const double truth_motion = std::sqrt(sums[top].moments()[0] / std::max(1.0, told_));
    if (truth_motion < kLagLeastMotion) return std::nullopt;
    const double before = agreement[top - 1], after = agreement[top + 1];
    const double bend = before - 2 * agreement[top] + after;
    const double aside = bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
    return TrackerLag{shift_s(static_cast<double>(top) + aside), 0, agreement[top]};
  }

  std::ptrdiff_t each_way_;
  double told_ = 0;
  double frame_s_ = 0;
  LagTable table_;
};

/// Mean squares over shapes and frames.
std::optional<double> mean_square(std::span<const face::BlendshapeWeights> truth,
                                  std::span<const face::BlendshapeWeights> estimate,
                                  const ToldShapes& shapes) {
  const std::vector<std::size_t> indices = indices_of(shapes);
  if (indices.empty() || truth.empty()) return std::nullopt;
  double squares = 0;
  for (std::size_t f = 0; f < truth.size(); ++f)
    for (const std::size_t k : indices) {
      const double error = double{held_to_unit(estimate[f][k])} - double{held_to_unit(truth[f][k])};
      squares += error * error;
    }
  return squares / static_cast<double>(truth.size() * indices.size());
}

/// An estimate of some frames beside the truth of the same.
struct FramePairs {
  std::vector<face::BlendshapeWeights> truth, estimate;
};

/// Measures one tracker; what it does not tell is the truth's.
class ScoreMaker {
 public:
  ScoreMaker(const measure::Meter& meter, const CurveComparison& comparison, const ToldShapes& told)
      : meter_(meter), comparison_(comparison), told_(told) {}

  [[nodiscard]] CurveErrors errors(const FramePairs& pairs, std::vector<float>* pve_mm = nullptr) const {
    std::vector<face::BlendshapeWeights> filled = pairs.estimate;
    for (std::size_t f = 0; f < filled.size(); ++f)
      for (std::size_t k = 0; k < face::kShapeCount; ++k)
        if (!told_[k]) filled[f][k] = pairs.truth[f][k];
    const measure::Stretch stretch{.truth = pairs.truth, .estimate = filled};
    measure::Metrics metrics = meter_.measure(std::span(&stretch, 1));
    if (pve_mm != nullptr) *pve_mm = std::move(metrics.pve_mm_curve);
    return {metrics.pve_mm.mean, optional_mean(metrics.pve_face_mm), optional_mean(metrics.lmk_mm),
            mean_square(pairs.truth, pairs.estimate, told_).value_or(0),
            mean_square(pairs.truth, pairs.estimate, comparison_.common)};
  }
  /// Over the frames that it saw, moved by `shift_s`; absent where it saw none.
  [[nodiscard]] std::optional<CurveErrors> seen_errors(const TimeLine& line, double shift_s) const {
    FramePairs pairs;
    for (std::size_t f = 0; f < comparison_.time_s.size(); ++f)
      if (const auto estimate = line.at(comparison_.time_s[f] + shift_s)) {
        pairs.truth.push_back(comparison_.truth[f]);
        pairs.estimate.push_back(*estimate);
      }
    if (pairs.truth.empty()) return std::nullopt;
    return errors(pairs);
  }

 private:
  const measure::Meter& meter_;
  const CurveComparison& comparison_;
  ToldShapes told_;
};

/// One tracker, and where it lies beside the truth.
struct PlacedCurves {
  const TrackerCurves& curves;
  ToldShapes told;
  TimeLine line;
  std::optional<TrackerLag> lag;
  double moved_s = 0;  // Taken off its times.
};

CurveScore tracker_score(const measure::Meter& meter, const CurveComparison& comparison,
                         const PlacedCurves& placed, const ToldShapes& truth_told) {
  const auto& [curves, told, line, lag, moved_s] = placed;
  const ScoreMaker maker(meter, comparison, told);
  CurveScore out;
  out.name = curves.name;
  out.told_shapes = told;
  out.lag = lag;
  out.offset_unknown = !comparison.shared_clock && !lag;
  FramePairs whole{comparison.truth, {}};
  for (const double time_s : comparison.time_s) {
    const bool saw = line.at(time_s + moved_s).has_value();
    out.saw.push_back(saw);
    out.seen += saw ? 1 : 0;
    face::BlendshapeWeights& shown = whole.estimate.emplace_back(line.held_at(time_s + moved_s));
    // Of what the truth does not tell nobody knows whether it is right.
    for (std::size_t k = 0; k < face::kShapeCount; ++k)
      if (!truth_told[k]) shown[k] = comparison.truth[whole.estimate.size() - 1][k];
  }
  const auto frames = static_cast<double>(comparison.time_s.size());
  out.gap_share = 1 - static_cast<double>(out.seen) / frames;
  out.as_told = maker.seen_errors(line, 0);
  if (lag) out.without_lag = maker.seen_errors(line, lag->lag_s);
  out.held = maker.errors(whole, &out.pve_mm);
  if (told == truth_told) {
    out.pve_whole_mm = out.held.pve_mm;
  } else {
    const measure::Stretch stretch{.truth = whole.truth, .estimate = whole.estimate};
    out.pve_whole_mm = meter.measure(std::span(&stretch, 1)).pve_mm.mean;
  }
  out.mse_whole = mean_square(whole.truth, whole.estimate, truth_told).value_or(0);
  out.shown = std::move(whole.estimate);
  return out;
}

std::string time_range(const TrackerCurves& curves, double moved_s = 0) {
  return fmt::format("{} is from {:.3f} to {:.3f} s", curves.name, curves.first_s() - moved_s,
                     curves.last_s() - moved_s);
}

Result<void> check_curves(const TrackerCurves& truth, std::span<const TrackerCurves> trackers,
                          const CompareSettings& settings) {
  if (trackers.empty()) return fail(ErrorCode::bad_usage, "there is no tracker to compare", truth.name);
  if (!(settings.search_s > 0 && settings.search_s <= kWidestSearch_s))
    return fail(ErrorCode::bad_usage, fmt::format("lags are sought within 0 to {} s", kWidestSearch_s));
  if (std::ranges::none_of(truth.rows, [](const TrackerRow& row) { return row.weights.has_value(); }))
    return fail(ErrorCode::not_found, "the truth has no row with a face", truth.name);
  for (std::size_t i = 0; i < trackers.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      if (trackers[i].name == trackers[j].name)
        return fail(ErrorCode::bad_usage, "two trackers have one name", trackers[i].name);
    if ((trackers[i].told & truth.told).none())
      return fail(ErrorCode::mismatch, "it tells no shape that the truth tells", trackers[i].name);
    const double begin_s = std::max(truth.first_s(), trackers[i].first_s());
    const double end_s = std::min(truth.last_s(), trackers[i].last_s());
    if (trackers[i].rows.empty() || end_s - begin_s < kLeastOverlap_s)
      return fail(
          ErrorCode::mismatch,
          fmt::format("it has less than a second in common with the truth: {}, {}", time_range(trackers[i]),
                      time_range(truth)),
          trackers[i].name,
          "move it by --offset, or leave out --shared-clock so that both count from their beginnings");
  }
  return {};
}

/// The truth's frames in the time that all have in common.
Result<CurveComparison> frames_in_common(const TrackerCurves& truth, std::span<const PlacedCurves> placed) {
  CurveComparison out;
  out.common = truth.told;
  double begin_s = truth.first_s(), end_s = truth.last_s();
  for (const PlacedCurves& tracker : placed) {
    out.common &= tracker.told;
    begin_s = std::max(begin_s, tracker.curves.first_s() - tracker.moved_s);
    end_s = std::min(end_s, tracker.curves.last_s() - tracker.moved_s);
  }
  if (end_s - begin_s < kLeastOverlap_s) {
    std::vector<std::string> ranges;
    for (const PlacedCurves& tracker : placed) ranges.push_back(time_range(tracker.curves, tracker.moved_s));
    return fail(ErrorCode::mismatch,
                fmt::format("the recordings have less than a second in common: {}", fmt::join(ranges, ", ")),
                truth.name, "leave one of them out");
  }
  for (const TrackerRow& row : truth.rows) {
    if (!row.weights || row.time_s < begin_s || row.time_s > end_s) continue;
    out.time_s.push_back(row.time_s);
    out.truth.push_back(*row.weights);
  }
  if (out.time_s.empty())
    return fail(ErrorCode::not_found, "the truth has no row with a face while all trackers run", truth.name);
  return out;
}

}  // namespace

Result<CurveComparison> compare_curves(const measure::Meter& meter, const TrackerCurves& truth,
                                       std::span<const TrackerCurves> trackers,
                                       const CompareSettings& settings) {
  MIEN_TRY(check_curves(truth, trackers, settings));
  std::vector<PlacedCurves> placed;
  for (const TrackerCurves& tracker : trackers)
    placed.push_back({tracker, tracker.told & truth.told, TimeLine(tracker), {}, 0});
  MIEN_TRY_ASSIGN(CurveComparison out, frames_in_common(truth, placed));
  const TruthForLags beside = truth_for_lags(out, TimeLine(truth));
  for (PlacedCurves& tracker : placed)
    tracker.lag = LagSearch(beside, tracker.line, tracker.told, settings.search_s).find();
  if (!settings.shared_clock) {
    for (PlacedCurves& tracker : placed) tracker.moved_s = tracker.lag ? tracker.lag->lag_s : 0;
    MIEN_TRY_ASSIGN(out, frames_in_common(truth, placed));
  }
  out.shared_clock = settings.shared_clock;
  for (const PlacedCurves& tracker : placed)
    out.scores.push_back(tracker_score(meter, out, tracker, truth.told));
  return out;
}

}  // namespace mien::lab
