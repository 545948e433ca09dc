#include "mien/mocap/marker_swaps.h"

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>

#include "mien/core/median.h"

namespace mien::mocap {
namespace {

constexpr float kNeighboursM = 0.03F;
/// Longest gap, s: after a longer one markers may have moved there by themselves.
constexpr double kCrossingGapS = 0.1;
constexpr double kJumpGapS = 0.5;
/// Crossing: largest distance to the other's position, as a share of the pair's distance, and the least
/// distance of a pair, m.
constexpr float kNear = 0.5F;
constexpr float kApartM = 2e-3F;
/// Least mean cosine between a pair's vector and its median: below it a stretch is ambiguous.
constexpr double kFits = 0.3;
/// Cost of a false crossing, in frames of the wrong orientation.
constexpr double kCrossingCost = 25;
/// Most frames that a stretch's evidence counts for: an expression is held for a second.
constexpr double kMostFrames = 100;

/// Lips and jaws reach 1.4 m/s in a virtual performer's speech and range of motion.
constexpr double kJumpMPerS = 2.0;
constexpr double kJumpM = 0.01;
constexpr double kStrayS = 3.0;
/// Returned: within this share of its jump from where it was.
constexpr float kBack = 0.5F;

/// A stretch of frames between two crossings, or between gaps.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool after_crossing = false;
  double cosine = 0;  // Sum over its frames.
  std::size_t frames = 0;
};

std::vector<Stretch> stretches_of(const MarkerTrack& track, std::size_t a, std::size_t b,
                                  const Vec3f& usual) {
  std::vector<Stretch> stretches;
  std::optional<std::size_t> last;
  const Vec3f home = usual.normalized();
  for (std::size_t i = 0; i < track.frames(); ++i) {
    const auto now = track.frame(i);
    if (!is_seen(now[a]) || !is_seen(now[b])) continue;
    const Vec3f apart = now[a] - now[b];
    bool crossed = false;
    const bool gap = !last || track.time_s[i] - track.time_s[*last] > kCrossingGapS;
    if (!gap) {
      const auto before = track.frame(*last);
      const float reach = kNear * (before[a] - before[b]).norm();
      crossed = reach > kNear * kApartM && (now[a] - before[b]).norm() < reach &&
                (now[b] - before[a]).norm() < reach;
    }
    if (gap || crossed) stretches.push_back({.begin = i, .after_crossing = crossed});
    Stretch& stretch = stretches.back();
    stretch.end = i + 1;
    ++stretch.frames;
    if (apart.norm() > kApartM) stretch.cosine += static_cast<double>(apart.normalized().dot(home));
    last = i;
  }
  return stretches;
}

/// Whether the labels are swapped in each stretch: the maximum likelihood sequence.
std::vector<bool> crossed_stretches(const std::vector<Stretch>& stretches) {
  std::vector<std::array<std::size_t, 2>> from;
  std::array<double, 2> score{};
  for (const Stretch& stretch : stretches) {
    const double share = std::min(1.0, kMostFrames / static_cast<double>(stretch.frames));
    const double straight = share * stretch.cosine;
    std::array<double, 2> next{};
    std::array<std::size_t, 2> came{};
    for (std::size_t state = 0; state < 2; ++state) {
      std::array<double, 2> arriving = score;
      if (stretch.after_crossing) arriving[state] -= kCrossingCost;
      came[state] = arriving[0] >= arriving[1] ? 0 : 1;
      next[state] = arriving[came[state]] + (state == 0 ? straight : -straight);
    }
    from.push_back(came);
    score = next;
  }
  std::vector<bool> crossed(stretches.size());
  std::size_t state = score[0] >= score[1] ? 0 : 1;
  for (std::size_t s = stretches.size(); s-- > 0;) {
    crossed[s] = state == 1;
    state = from[s][state];
  }
  return crossed;
}

void mend_pair(MarkerTrack& track, std::size_t a, std::size_t b, const Vec3f& usual,
               std::vector<MarkerSwap>& swaps) {
  const std::vector<Stretch> stretches = stretches_of(track, a, b, usual);
  if (stretches.size() < 2) return;
  const std::vector<bool> crossed = crossed_stretches(stretches);
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    const Stretch& stretch = stretches[s];
    // Stretches before the first crossing and after a gap are taken as labelled, unless the evidence is
    // strong.
    const double mean = stretch.cosine / static_cast<double>(stretch.frames);
    const bool beside_crossing =
        stretch.after_crossing || (s + 1 < stretches.size() && stretches[s + 1].after_crossing);
    const bool clear = crossed[s] ? mean < -kFits : mean > kFits;
    if (clear ? !crossed[s] : !crossed[s] || !beside_crossing) continue;
    swaps.push_back({.a = a, .b = b, .begin = stretch.begin, .end = stretch.end, .mended = clear});
    for (std::size_t i = stretch.begin; i < stretch.end; ++i) {
      const auto frame = track.frame(i);
      if (clear)
        std::swap(frame[a], frame[b]);
      else
        frame[a] = frame[b] = kLostMarker;
    }
  }
}

}  // namespace

std::vector<Vec3f> usual_places(const MarkerTrack& track) {
  std::vector<Vec3f> places(track.count(), kLostMarker);
  for (std::size_t m = 0; m < track.count(); ++m)
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      std::vector<float> values;
      for (std::size_t i = 0; i < track.frames(); ++i)
        if (const Vec3f& position = track.frame(i)[m]; is_seen(position)) values.push_back(position[axis]);
      if (values.empty()) break;
      places[m][axis] = upper_median(std::move(values));
    }
  return places;
}

std::vector<MarkerSwap> mend_swaps(MarkerTrack& track) {
  const std::vector<Vec3f> places = usual_places(track);
  // By rising distance: the nearest are swapped most often.
  std::vector<std::tuple<float, std::size_t, std::size_t>> pairs;
  for (std::size_t a = 0; a < places.size(); ++a) {
    if (!is_seen(places[a])) continue;
    std::optional<std::tuple<float, std::size_t, std::size_t>> nearest;
    for (std::size_t b = 0; b < places.size(); ++b) {
      if (b == a || !is_seen(places[b])) continue;
      const std::tuple pair((places[a] - places[b]).norm(), std::min(a, b), std::max(a, b));
      if (!nearest || pair < *nearest) nearest = pair;
      if (a < b && std::get<0>(pair) < kNeighboursM) pairs.push_back(pair);
    }
    if (nearest) pairs.push_back(*nearest);
  }
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  std::vector<MarkerSwap> swaps;
  for (const auto& [distance, a, b] : pairs)
    if (distance > kApartM) mend_pair(track, a, b, places[a] - places[b], swaps);
  return swaps;
}

std::vector<MarkerStray> lose_strays(MarkerTrack& track) {
  std::vector<MarkerStray> strays;
  for (std::size_t m = 0; m < track.count(); ++m) {
    std::optional<std::size_t> last;    // Last frame with the marker, ...
    std::optional<std::size_t> jumped;  // ... the first after a jump, ...
    Vec3f from = kLostMarker;           // ... and the position before it.
    for (std::size_t i = 0; i < track.frames(); ++i) {
      const Vec3f now = track.frame(i)[m];
      if (!is_seen(now)) continue;
      if (last) {
        const Vec3f before = track.frame(*last)[m];
        const double step_s = track.time_s[i] - track.time_s[*last];
        const auto step_m = static_cast<double>((now - before).norm());
        if (step_s < kJumpGapS && step_m > kJumpM && step_m > kJumpMPerS * step_s) {
          const bool back = jumped && track.time_s[i] - track.time_s[*jumped] < kStrayS &&
                            (now - from).norm() < kBack * (now - before).norm();
          if (back) {
            strays.push_back({.marker = m, .begin = *jumped, .end = i});
            for (std::size_t f = *jumped; f < i; ++f) track.frame(f)[m] = kLostMarker;
            jumped.reset();
          } else {
            jumped = i;
            from = before;
          }
        }
      }
      last = i;
    }
  }
  return strays;
}

}  // namespace mien::mocap
