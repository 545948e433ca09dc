#include "mien/headset/gaze_learner.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "mien/core/units.h"

namespace mien::headset {
namespace {

/// Share of a target's frames in which an eye must have been seen.
constexpr double kSeenLeast = 0.5;
/// Farther off targets than this the eyes did not rest on them, or are hardly seen.
constexpr double kMostOff_deg = 3;

sensor::Score score_of(const GazeFit& fit, std::size_t eye) {
  const double before_deg = kDegPerRad * fit.before[eye];
  const double off_deg = fit.kept[eye] ? kDegPerRad * fit.held_out[eye] : before_deg;
  const bool pass = off_deg <= kMostOff_deg;
  std::string sentence;
  if (!pass)
    sentence =
        "so far off the targets: look at each until the next is asked for, with the head still, or see to "
        "how the headset sits, and calibrate again";
  else if (fit.kept[eye])
    sentence =
        fmt::format("how far off targets that were left out of the fit; without it {:.1f}", before_deg);
  else
    sentence = "how far off the targets; no fit did better at those left out of it, so none is used";
  return {.name = eye == 0 ? "gaze left" : "gaze right",
          .value = off_deg,
          .unit = "deg",
          .pass = pass,
          .sentence = std::move(sentence)};
}

}  // namespace

void GazeLearner::ask(const face::GazeTarget& target, DeviceTime begin, DeviceTime end) {
  asked_.push_back({.target = target, .begin = begin, .end = end});
}

void GazeLearner::restart() {
  for (Asked& asked : asked_) asked = {.target = asked.target, .begin = asked.begin, .end = asked.end};
}

void GazeLearner::add(DeviceTime frame, const Found& found) {
  for (Asked& asked : asked_) {
    if (frame < asked.begin || frame >= asked.end) continue;
    for (std::size_t eye = 0; eye < found.size(); ++eye) {
      if (!found[eye]) continue;
      asked.sum[eye] += found[eye]->cast<double>();
      ++asked.frames[eye];
    }
  }
}

std::optional<Eigen::Vector2f> GazeLearner::Asked::mean(std::size_t eye) const {
  const auto seen = static_cast<double>(frames[eye]);
  if (seen == 0 || seen < kSeenLeast * kFrameRateHz * to_seconds(end - begin)) return {};
  return (sum[eye] / seen).cast<float>();
}

GazeLearner::Learnt GazeLearner::learn() const {
  std::vector<GazeSample> samples;
  std::array<bool, 2> seen{};
  for (const Asked& asked : asked_) {
    GazeSample& sample = samples.emplace_back();
    sample.known_rad = asked.target.direction_rad;
    for (std::size_t eye = 0; eye < seen.size(); ++eye) {
      sample.found_rad[eye] = asked.mean(eye);
      seen[eye] = seen[eye] || sample.found_rad[eye];
    }
  }
  // An eye that was never seen has no camera, or one that is lost: that is said elsewhere.
  std::vector<std::string_view> missed;
  for (std::size_t t = 0; t < samples.size(); ++t) {
    const auto misses = [&](std::size_t eye) { return seen[eye] && !samples[t].found_rad[eye]; };
    if ((!seen[0] && !seen[1]) || misses(0) || misses(1)) missed.push_back(asked_[t].target.name);
  }
  Learnt learnt;
  const auto fit = fit_gaze_map(samples);
  std::string sentence = "share of the targets at which the eyes were seen";
  if (!missed.empty())
    sentence = fmt::format("the eyes were shut, or not seen, at \"{}\"{}; calibrate again",
                           fmt::join(missed, "\", \""),
                           fit ? ", which was left out" : "; too little was seen to learn from");
  learnt.scores.push_back({.name = "gaze targets",
                           .value = 1 - static_cast<double>(missed.size()) /
                                            static_cast<double>(std::max<std::size_t>(1, samples.size())),
                           .unit = "",
                           .pass = missed.empty(),
                           .sentence = std::move(sentence)});
  if (!fit) return learnt;
  learnt.map = fit->map;
  for (std::size_t eye = 0; eye < seen.size(); ++eye)
    if (fit->fitted[eye]) learnt.scores.push_back(score_of(*fit, eye));
  return learnt;
}

}  // namespace mien::headset
