#include "lab/motion_rhythm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "mien/core/median.h"
#include "mien/face/shape_region.h"

namespace mien::lab {
namespace {

using face::kShapeCount;
using face::kShapeNames;
using face::shape;

constexpr float kRestWidth = 0.05F, kAtRest = 0.03F, kStill = 0.1F, kExpression = 0.15F;
constexpr double kMovingDeviation = 0.01;
/// A blink: lids rise and fall by this much within this time to both sides.
constexpr float kBlinkRise = 0.25F;
constexpr double kBlinkReach_s = 0.45;

/// The mean of what lies in the densest interval of kRestWidth. `values`: at least one.
float densest(std::vector<float> values) {
  std::ranges::sort(values);
  std::size_t best = 0, most = 0, end = 0;
  for (std::size_t begin = 0; begin < values.size(); ++begin) {
    while (end < values.size() && values[end] <= values[begin] + kRestWidth) ++end;
    if (end - begin > most) {
      most = end - begin;
      best = begin;
    }
  }
  double sum = 0;
  for (std::size_t i = best; i < best + most; ++i) sum += values[i];
  return static_cast<float>(sum / static_cast<double>(most));
}

/// The mean of the `width` samples about each one, fewer at the ends.
std::vector<double> smoothed(const std::vector<double>& x, std::size_t width) {
  std::vector<double> sums(x.size() + 1, 0);
  for (std::size_t i = 0; i < x.size(); ++i) sums[i + 1] = sums[i] + x[i];
  std::vector<double> out(x.size());
  const std::size_t half = width / 2;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const std::size_t from = i < half ? 0 : i - half, to = std::min(x.size(), i + half + 1);
    out[i] = (sums[to] - sums[from]) / static_cast<double>(to - from);
  }
  return out;
}

double energy(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// How long the excursions of one shape last, in frames.
void add_excursions(const MotionRun& run, std::size_t k, float rest, std::vector<float>& frames) {
  std::size_t count = 0;
  for (const face::BlendshapeWeights& weights : run) {
    if (std::abs(weights[k] - rest) > kExpression) {
      ++count;
    } else if (count > 0) {
      frames.push_back(static_cast<float>(count));
      count = 0;
    }
  }
  if (count > 0) frames.push_back(static_cast<float>(count));
}

struct BlinksFound {
  std::vector<float> frames, closing_share, peak, side_difference;
};

void find_blinks(const MotionRun& run, double rate_hz, BlinksFound& found) {
  const std::size_t left = shape("eyeBlink_L"), right = shape("eyeBlink_R");
  const auto lids = [&](std::size_t i) { return 0.5F * (run[i][left] + run[i][right]); };
  const auto reach = static_cast<std::size_t>(std::max(1.0, kBlinkReach_s * rate_hz));
  for (std::size_t i = 1; i + 1 < run.size(); ++i) {
    const float peak = lids(i);
    if (peak < lids(i - 1) || peak <= lids(i + 1)) continue;
    const std::size_t from = i < reach ? 0 : i - reach, to = std::min(run.size() - 1, i + reach);
    float before = peak, after = peak;
    bool is_largest = true;
    for (std::size_t j = from; j <= to; ++j) {
      is_largest = is_largest && (lids(j) < peak || (lids(j) == peak && j <= i));
      (j < i ? before : after) = std::min(j < i ? before : after, lids(j));
    }
    if (!is_largest || peak - before < kBlinkRise || peak - after < kBlinkRise) continue;
    const float half = peak - 0.5F * std::min(peak - before, peak - after);
    std::size_t begin = i, end = i;
    while (begin > from && lids(begin - 1) >= half) --begin;
    while (end < to && lids(end + 1) >= half) ++end;
    const auto frames = static_cast<float>(end - begin + 1);
    found.frames.push_back(frames);
    found.closing_share.push_back((static_cast<float>(i - begin) + 0.5F) / frames);
    found.peak.push_back(peak);
    found.side_difference.push_back(std::abs(run[i][left] - run[i][right]));
  }
}

/// By MotionRhythm's four durations, slowest first.
using Bands = std::array<double, 4>;
void add_bands(std::span<const MotionRun> runs, std::size_t k, double mean, double rate_hz, Bands& sums) {
  const auto frames = [&](double s) { return static_cast<std::size_t>(std::max(1.0, s * rate_hz)); };
  for (const MotionRun& run : runs) {
    std::vector<double> x(run.size());
    for (std::size_t i = 0; i < run.size(); ++i) x[i] = run[i][k] - mean;
    const std::vector<double> fine = smoothed(x, frames(0.25)), middle = smoothed(x, frames(1)),
                              coarse = smoothed(x, frames(4));
    sums[0] += energy(coarse, std::vector<double>(x.size(), 0.0));
    sums[1] += energy(middle, coarse);
    sums[2] += energy(fine, middle);
    sums[3] += energy(x, fine);
  }
}

/// 99th percentile of the speed's magnitude over its root mean square; none where nothing moves.
std::optional<double> speed_tail(std::span<const MotionRun> runs, std::size_t k) {
  std::vector<float> speeds;
  double squares = 0;
  for (const MotionRun& run : runs)
    for (std::size_t i = 1; i < run.size(); ++i) {
      speeds.push_back(std::abs(run[i][k] - run[i - 1][k]));
      squares += speeds.back() * speeds.back();
    }
  if (!(squares > 0)) return std::nullopt;
  const double rms = std::sqrt(squares / static_cast<double>(speeds.size()));
  return percentile(std::move(speeds), 0.99) / rms;
}

}  // namespace

ShapeGroup group_of(std::size_t shape) {
  if (kShapeNames[shape].starts_with("eyeLook")) return ShapeGroup::gaze;
  switch (face::kShapeRegions[shape]) {
    case face::ShapeRegion::brows:
      return ShapeGroup::brows;
    case face::ShapeRegion::eyes:
      return ShapeGroup::lids;
    case face::ShapeRegion::cheeks:
      return ShapeGroup::cheeks;
    case face::ShapeRegion::mouth:
      return ShapeGroup::mouth;
    case face::ShapeRegion::jaw:
      break;
  }
  return ShapeGroup::jaw;
}

double percentile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

MotionRhythm motion_rhythm(std::span<const MotionRun> runs, double rate_hz) {
  MotionRhythm out;
  std::size_t frames = 0;
  for (const MotionRun& run : runs) frames += run.size();
  if (frames == 0) return out;
  const auto all = static_cast<double>(frames);

  face::BlendshapeWeights rest;
  std::vector<float> excursions;
  double resting = 0, moving = 0;
  Bands bands{};
  for (std::size_t k = 0; k < kShapeCount; ++k) {
    std::vector<float> values;
    values.reserve(frames);
    double mean = 0, mean_square = 0;
    for (const MotionRun& run : runs)
      for (const face::BlendshapeWeights& weights : run) {
        values.push_back(weights[k]);
        mean += weights[k];
        mean_square += weights[k] * weights[k];
      }
    mean /= all;
    mean_square /= all;
    add_bands(runs, k, mean, rate_hz, bands);
    if (mean_square - mean * mean > kMovingDeviation * kMovingDeviation)
      if (const std::optional<double> tail = speed_tail(runs, k)) {
        out.speed_tail += *tail;
        ++moving;
      }
    rest[k] = densest(values);
    const ShapeGroup group = group_of(k);
    if (group == ShapeGroup::gaze) continue;
    ++resting;
    out.rest_share += static_cast<double>(std::ranges::count_if(
                          values, [&](float value) { return std::abs(value - rest[k]) <= kAtRest; })) /
                      all;
    if (group == ShapeGroup::lids) continue;
    for (const MotionRun& run : runs) add_excursions(run, k, rest[k], excursions);
  }
  out.rest_share /= resting;
  out.speed_tail /= std::max(1.0, moving);
  if (const double sum = bands[0] + bands[1] + bands[2] + bands[3]; sum > 0) {
    out.slowest = bands[0] / sum;
    out.slow = bands[1] / sum;
    out.quick = bands[2] / sum;
    out.quickest = bands[3] / sum;
  }
  for (const MotionRun& run : runs)
    for (const face::BlendshapeWeights& weights : run) {
      bool still = true;
      for (std::size_t k = 0; k < kShapeCount && still; ++k)
        still = group_of(k) == ShapeGroup::gaze || group_of(k) == ShapeGroup::lids ||
                std::abs(weights[k] - rest[k]) <= kStill;
      if (still) out.still_share += 1 / all;
    }
  out.expression_s = percentile(excursions, 0.5) / rate_hz;
  out.long_expression_s = percentile(std::move(excursions), 0.9) / rate_hz;

  BlinksFound blinks;
  for (const MotionRun& run : runs) find_blinks(run, rate_hz, blinks);
  if (!blinks.peak.empty()) {
    out.blinks_per_min = static_cast<double>(blinks.peak.size()) / (all / rate_hz / 60);
    out.blink_s = upper_median(std::move(blinks.frames)) / rate_hz;
    out.blink_closing_share = upper_median(std::move(blinks.closing_share));
    out.blink_peak = upper_median(std::move(blinks.peak));
    out.blink_side_difference = upper_median(std::move(blinks.side_difference));
  }
  return out;
}

}  // namespace mien::lab
