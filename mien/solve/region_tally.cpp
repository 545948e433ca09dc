#include "mien/solve/region_tally.h"

#include <cmath>

#include "mien/model/confidence.h"

namespace mien::solve {

std::array<bool, face::kShapeRegionCount> regions_within(const face::BlendshapeWeights& estimate,
                                                         const face::BlendshapeWeights& truth) {
  std::array<float, face::kShapeRegionCount> error{}, shapes{};
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const auto region = static_cast<std::size_t>(face::kShapeRegions[k]);
    error[region] += std::abs(estimate[k] - truth[k]);
    shapes[region] += 1;
  }
  std::array<bool, face::kShapeRegionCount> out{};
  for (std::size_t r = 0; r < out.size(); ++r) out[r] = error[r] <= model::kConfidenceTolerance * shapes[r];
  return out;
}

void RegionTally::add(const face::OutputFrame& frame, const face::BlendshapeWeights& truth) {
  const auto within = regions_within(frame.weights, truth);
  for (std::size_t r = 0; r < within.size(); ++r) {
    const float confidence = frame.region_confidence[r];
    all.add(confidence, within[r]);
    roc.add(confidence, within[r]);
    each[r].add(confidence, within[r]);
    roc_each[r].add(confidence, within[r]);
  }
}

void RegionTally::add(const RegionTally& other) {
  all.add(other.all);
  roc.add(other.roc);
  for (std::size_t r = 0; r < each.size(); ++r) {
    each[r].add(other.each[r]);
    roc_each[r].add(other.roc_each[r]);
  }
}

std::optional<double> expected_region_error(const std::vector<measure::TakeEstimates>& takes) {
  Reliability known;
  std::size_t count = 0;
  for (const measure::TakeEstimates& take : takes) {
    if (take.region_confidence.empty()) continue;
    for (const auto& [begin, end] : measure::evaluated_runs(take.truth))
      for (std::size_t i = begin; i < end; ++i) {
        const auto within = regions_within(take.model[i], take.truth[i].weights);
        for (std::size_t r = 0; r < within.size(); ++r) {
          const float confidence = take.region_confidence[i][r];
          if (confidence <= 0) continue;
          known.add(confidence, within[r]);
          ++count;
        }
      }
  }
  if (count == 0) return std::nullopt;
  return known.expected_error();
}

}  // namespace mien::solve
