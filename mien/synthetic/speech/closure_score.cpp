#include "mien/synthetic/speech/closure_score.h"

namespace mien::synthetic {

ClosureScore score_closures(std::span<const Closure> truth, std::span<const Closure> heard,
                            double tolerance_s) {
  ClosureScore score{.truths = truth.size(), .heard = heard.size()};
  // Intervals in order, each matched with the first that is still free: as many pairs as there can be.
  for (std::size_t t = 0, h = 0; t < truth.size() && h < heard.size();) {
    if (heard[h].end_s < truth[t].begin_s - tolerance_s) {
      ++h;
    } else if (heard[h].begin_s > truth[t].end_s + tolerance_s) {
      ++t;
    } else {
      ++score.found;
      ++t;
      ++h;
    }
  }
  return score;
}

std::vector<Closure> stretches_above(std::span<const float> track, float threshold, double first_s,
                                     double step_s) {
  std::vector<Closure> stretches;
  bool above = false;
  for (std::size_t i = 0; i < track.size(); ++i) {
    const double at_s = first_s + step_s * static_cast<double>(i);
    if (track[i] >= threshold) {
      if (!above) stretches.push_back({at_s - 0.5 * step_s, at_s});
      stretches.back().end_s = at_s + 0.5 * step_s;
    }
    above = track[i] >= threshold;
  }
  return stretches;
}

}  // namespace mien::synthetic
