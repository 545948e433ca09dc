#include "lab/speech/hand_over.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "lab/speech/mouth_score.h"
#include "mien/speech/listener.h"

namespace mien::lab {
namespace {

using face::OutputFrame;

/// Frames of a quarter of a second.
constexpr std::size_t kQuarter = 15;

/// Sum of squares of the third differences of mouth and jaw in frames [first, last).
double squared_jerk(std::span<const OutputFrame> frames, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t f = std::max<std::size_t>(first, 3); f < std::min(last, frames.size()); ++f)
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      if (!speech::is_heard(k)) continue;
      const auto w = [&](std::size_t back) { return double{frames[f - back].weights[k]}; };
      const double third = w(0) - 3 * w(1) + 3 * w(2) - w(3);
      sum += third * third;
    }
  return sum;
}

bool claims(const OutputFrame& frame) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (speech::is_heard(k) && claims_to_be_sensed(frame.provenance[k])) return true;
  return false;
}

bool is_as(const OutputFrame& frame, const OutputFrame& other) {
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    if (speech::is_heard(k) && frame.provenance[k] != other.provenance[k]) return false;
  return true;
}

double seconds_between(std::size_t from, std::size_t to, std::size_t never) {
  return to == never ? std::numeric_limits<double>::infinity()
                     : static_cast<double>(to - from) / kFrameRateHz;
}

}  // namespace

bool claims_to_be_sensed(face::Provenance provenance) {
  using face::Provenance;
  return provenance == Provenance::measured || provenance == Provenance::interpolated ||
         provenance == Provenance::predicted;
}

HandOver judge_hand_over(const Unsensed& loss, const ShownOver& over, const measure::Meter& meter) {
  const auto& [shown, steady, meanwhile, truth] = over;
  const auto [lost, back] = loss;
  assert(lost >= kQuarter && back >= lost);
  std::size_t noticed = lost, recovered = back;
  while (noticed < back && claims(shown[noticed])) ++noticed;
  const std::size_t end = std::min(shown.size(), steady.size());
  while (recovered < end && !is_as(shown[recovered], steady[recovered])) ++recovered;
  // Each moment beside whoever answers then.
  const auto ratio = [&](std::size_t at, std::size_t hands, std::span<const OutputFrame> before,
                         std::span<const OutputFrame> after) {
    const double usual =
        squared_jerk(before, at - kQuarter, hands) + squared_jerk(after, hands, hands + kQuarter);
    return usual == 0 ? 0 : std::sqrt(squared_jerk(shown, at - kQuarter, hands + kQuarter) / usual);
  };
  HandOver out;
  out.jerk_ratio =
      std::max(ratio(lost, noticed, steady, meanwhile), ratio(back, recovered, meanwhile, steady));
  out.notice_s = seconds_between(lost, noticed, back);
  out.recover_s = seconds_between(back, recovered, end);
  std::vector<face::BlendshapeWeights> during;
  for (std::size_t f = lost; f < back; ++f) during.push_back(shown[f].weights);
  const measure::Stretch stretch{truth.subspan(lost, back - lost), during};
  out.mouth_mm = score_mouth(meter, {&stretch, 1}).mouth_mm;
  return out;
}

double mid_sentence(const synthetic::SpokenPassage& passage, double for_s) {
  const double wanted_s = 0.4 * (passage.utterance.duration_s - for_s);
  const auto spoken = [&](double t) {
    double voiced = 0;
    for (double s = t; s < t + for_s; s += 0.02) voiced += passage.voiced_at(s) ? 1 : 0;
    return passage.voiced_at(t) ? voiced : 0;
  };
  double best_s = wanted_s;
  for (double t = wanted_s - 2; t < wanted_s + 2; t += 0.02)
    if (t > 1 && t + for_s + 1 < passage.utterance.duration_s && spoken(t) > spoken(best_s)) best_s = t;
  return best_s;
}

}  // namespace mien::lab
