#include "mien/phone/taps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/core/time.h"

namespace mien::phone {
namespace {

/// Taps are so far apart, s: a finger is no faster, and who taps slower does something else.
constexpr double kLeastGap_s = 0.2, kMostGap_s = 0.8;
/// The same gap, as two devices at 60 Hz see it, differs by less, s.
constexpr double kSameGap_s = 0.06;
/// Offsets of the same taps, or of taps at the beginning and at the end, s: the phone's lag and its drift
/// over an hour are less.
constexpr double kSameOffset_s = 0.15;
/// A tap has rung out after so long, s; a movement that lasts longer is none.
constexpr double kTapLasts_s = 0.18;
/// Nothing else moves for so long before and after, s, by more than this share of the weakest tap.
constexpr double kQuiet_s = 1.0, kQuietShare = 0.4;
/// One finger's taps are about as strong as each other.
constexpr double kMostUneven = 3;
/// Across a longer gap nothing is one movement, nor disturbs another, s.
constexpr double kMostGapInFrames_s = kQuiet_s + 0.1;
/// From both ends of what a phone told taps are looked for within this, s.
constexpr double kEnds_s = 30;
/// A weaker jolt is none. Speech accelerates a chin by up to 3 m/s^2 (5 mm at 4 Hz).
constexpr double kLeastJolt_m_s2 = 4;
/// A phone's jaw and head that jump less are its noise: jawOpen, and 0.5 degrees.
constexpr double kLeastJawJump = 0.02, kLeastHeadJump_rad = 0.009;
/// A jump is what a value is off the middle between what it is this much before and after, s.
constexpr double kJumpAround_s = 0.1;

constexpr auto kPlaceOf = [](double time_s) {
  return static_cast<std::ptrdiff_t>(std::lround(time_s * kFrameRateHz));
};

/// When three taps were, s.
using ThreeTaps = std::array<double, 3>;

/// Whether nothing else is strong around three taps, at frames.
bool stand_alone(std::span<const double> strength, const std::array<std::ptrdiff_t, 3>& taps,
                 double weakest) {
  const auto count = static_cast<std::ptrdiff_t>(strength.size());
  const std::ptrdiff_t around = kPlaceOf(kQuiet_s), lasts = kPlaceOf(kTapLasts_s);
  const std::ptrdiff_t end = std::min(count, taps[2] + around + 1);
  for (std::ptrdiff_t at = std::max<std::ptrdiff_t>(0, taps[0] - around); at < end; ++at) {
    const bool of_a_tap =
        std::ranges::any_of(taps, [&](std::ptrdiff_t tap) { return std::abs(at - tap) <= lasts; });
    if (!of_a_tap && strength[static_cast<std::size_t>(at)] > kQuietShare * weakest) return false;
  }
  return true;
}

/// All threes of taps in a strength at kFrameRateHz that begins at `begin_s`.
std::vector<ThreeTaps> threes_in(std::span<const double> strength, double begin_s, double least) {
  const auto count = static_cast<std::ptrdiff_t>(strength.size());
  const auto at = [&](std::ptrdiff_t place) { return strength[static_cast<std::size_t>(place)]; };
  // A tap is the strongest around it, the first of equals.
  const std::ptrdiff_t apart = kPlaceOf(0.75 * kLeastGap_s);
  std::vector<std::ptrdiff_t> peaks;
  for (std::ptrdiff_t place = 0; place < count; ++place) {
    if (!(at(place) >= least)) continue;
    bool highest = true;
    for (std::ptrdiff_t other = std::max<std::ptrdiff_t>(0, place - apart);
         other < std::min(count, place + apart + 1) && highest; ++other)
      highest = other < place ? at(other) < at(place) : at(other) <= at(place);
    if (highest) peaks.push_back(place);
  }
  const std::ptrdiff_t least_gap = kPlaceOf(kLeastGap_s), most_gap = kPlaceOf(kMostGap_s);
  std::vector<ThreeTaps> out;
  for (auto first = peaks.begin(); first != peaks.end(); ++first)
    for (auto second = first + 1; second != peaks.end() && *second - *first <= most_gap; ++second) {
      if (*second - *first < least_gap) continue;
      for (auto third = second + 1; third != peaks.end() && *third - *second <= most_gap; ++third) {
        if (*third - *second < least_gap) continue;
        const auto [weakest, strongest] = std::minmax({at(*first), at(*second), at(*third)});
        if (strongest > kMostUneven * weakest || !stand_alone(strength, {*first, *second, *third}, weakest))
          continue;
        const auto time_s = [&](std::ptrdiff_t place) {
          return begin_s + static_cast<double>(place) / kFrameRateHz;
        };
        out.push_back({time_s(*first), time_s(*second), time_s(*third)});
      }
    }
  return out;
}

/// What sensors felt in frames between which no gap is longer than kMostGapInFrames_s, from `begin_s` on.
std::vector<ThreeTaps> felt_in(std::span<const model::FeatureFrame> stretch, double begin_s) {
  const DeviceTime begin = stretch.front().time;
  std::vector<double> jolt(static_cast<std::size_t>(kPlaceOf(to_seconds(stretch.back().time - begin))) + 1);
  for (const model::FeatureFrame& frame : stretch) {
    double& most = jolt[static_cast<std::size_t>(kPlaceOf(to_seconds(frame.time - begin)))];
    for (const model::SensorFeature& sensor : frame.sensors)
      if (sensor.has_accel) most = std::max(most, double{sensor.accel_m_s2.norm()});
  }
  return threes_in(jolt, begin_s, kLeastJolt_m_s2);
}

/// What sensors felt. Memory follows how many frames there are, whatever their times say.
std::vector<ThreeTaps> felt_taps(std::span<const model::FeatureFrame> skin) {
  std::vector<ThreeTaps> out;
  for (std::size_t begin = 0, end = 0; begin < skin.size(); begin = end) {
    const auto goes_on = [&](std::size_t at) {
      const Duration gap = skin[at].time - skin[at - 1].time;
      return gap >= Duration::zero() && to_seconds(gap) <= kMostGapInFrames_s;
    };
    for (end = begin + 1; end < skin.size() && goes_on(end); ++end) continue;
    const auto felt =
        felt_in(skin.subspan(begin, end - begin), to_seconds(skin[begin].time - skin.front().time));
    out.insert(out.end(), felt.begin(), felt.end());
  }
  return out;
}

/// What a phone told from `begin_s` on, before `end_s`.
void add_told_taps(const face::MotionCurve& curve, bool has_head, double begin_s, double end_s,
                   std::vector<ThreeTaps>& out) {
  constexpr std::size_t kJaw = face::shape("jawOpen");
  const auto count = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, kPlaceOf(end_s - begin_s)));
  std::vector<double> jaw(count), head(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double time_s = begin_s + static_cast<double>(i) / kFrameRateHz;
    const face::MotionFrame before = curve.at(time_s - kJumpAround_s), now = curve.at(time_s),
                            after = curve.at(time_s + kJumpAround_s);
    if (!before.has_face || !now.has_face || !after.has_face) continue;
    jaw[i] = std::abs(now.weights[kJaw] - 0.5 * (before.weights[kJaw] + after.weights[kJaw]));
    if (has_head) head[i] = angle_between(now.head, before.head.slerp(0.5, after.head));
  }
  for (const auto& [strength, least] : {std::pair(std::span(std::as_const(jaw)), kLeastJawJump),
                                        std::pair(std::span(std::as_const(head)), kLeastHeadJump_rad)})
    for (const ThreeTaps& taps : threes_in(strength, begin_s, least)) {
      const bool known = std::ranges::any_of(
          out, [&](const ThreeTaps& other) { return std::abs(other[0] - taps[0]) < kSameOffset_s; });
      if (!known) out.push_back(taps);
    }
}

std::vector<ThreeTaps> told_taps(const face::Motion& told) {
  std::vector<ThreeTaps> out;
  if (told.frames.size() < 2) return out;
  const face::MotionCurve curve(told);
  const double end_s = told.duration_s();
  if (end_s <= 2 * kEnds_s) {
    add_told_taps(curve, told.has_head, 0, end_s, out);
  } else {
    add_told_taps(curve, told.has_head, 0, kEnds_s, out);
    add_told_taps(curve, told.has_head, end_s - kEnds_s, end_s, out);
  }
  return out;
}

}  // namespace

std::optional<AlignmentPrior> prior_by_taps(std::span<const model::FeatureFrame> skin,
                                            const face::Motion& told) {
  const std::vector<ThreeTaps> seen = told_taps(told);
  if (seen.empty()) return std::nullopt;
  std::vector<double> offsets;
  for (const ThreeTaps& felt : felt_taps(skin))
    for (const ThreeTaps& taps : seen) {
      const bool same_rhythm = std::abs((felt[1] - felt[0]) - (taps[1] - taps[0])) < kSameGap_s &&
                               std::abs((felt[2] - felt[1]) - (taps[2] - taps[1])) < kSameGap_s;
      if (same_rhythm) offsets.push_back((felt[0] + felt[1] + felt[2] - taps[0] - taps[1] - taps[2]) / 3);
    }
  // One who taps at the beginning and at the end does so alike: the offset at which both are explained.
  std::ranges::sort(offsets);
  std::size_t most = 0, of_another = 0;
  double best_s = 0;
  for (std::size_t first = 0, end = 0; first < offsets.size(); first = end) {
    double sum_s = 0;
    for (end = first; end < offsets.size() && offsets[end] - offsets[first] < kSameOffset_s; ++end)
      sum_s += offsets[end];
    const std::size_t count = end - first;
    of_another = std::max(of_another, std::min(most, count));
    if (count <= most) continue;
    most = count;
    best_s = sum_s / static_cast<double>(count);
  }
  if (most == of_another) return std::nullopt;
  return AlignmentPrior{.offset_s = best_s};
}

}  // namespace mien::phone
