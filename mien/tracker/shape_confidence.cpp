#include "mien/tracker/shape_confidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mien::tracker {
namespace {

constexpr std::array<float, face::kShapeRegionCount> kShapesOfRegion = [] {
  std::array<float, face::kShapeRegionCount> counts{};
  for (const face::ShapeRegion region : face::kShapeRegions) counts[static_cast<std::size_t>(region)] += 1;
  return counts;
}();

/// From the sums over each region's shapes to their means.
RegionScores means(RegionScores sums) {
  for (std::size_t r = 0; r < sums.size(); ++r) sums[r] /= kShapesOfRegion[r];
  return sums;
}

}  // namespace

ShapeConfidence::ShapeConfidence(std::optional<model::ConfidenceTable> table) : table_(std::move(table)) {
  if (!table_) return;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    for (std::size_t bin = 0; bin < table_->coverage_bins(); ++bin)
      provenance_.push_back(provenance_of(*table_, k, bin));
  for (const float within : table_->within) {
    const float held = std::clamp(within, kLeastProbability, 1 - kLeastProbability);
    log_odds_.push_back(std::log(held / (1 - held)));
  }
}

std::size_t ShapeConfidence::row_of(std::size_t shape, float coverage) const {
  return shape * table_->coverage_bins() + model::confidence_bin(table_->coverage_edges, coverage);
}

std::size_t ShapeConfidence::cell_of(std::size_t row, float weight) const {
  return row * table_->value_bins() + model::confidence_bin(table_->value_edges, weight);
}

Explained ShapeConfidence::write(const Coverage& coverage, face::OutputFrame& out) const {
  Explained explained{};
  out.region_confidence.fill(0);
  if (!table_) {
    out.provenance.fill(face::Provenance::predicted);
    out.confidence.fill(0);
    return explained;
  }
  RegionScores scores{};
  for (std::size_t k = 0; k < face::kShapeCount; ++k) {
    const std::size_t row = row_of(k, coverage[k]), cell = cell_of(row, out.weights[k]);
    explained[k] = table_->explained[row];
    out.provenance[k] = provenance_[row];
    out.confidence[k] = table_->within[cell];
    scores[static_cast<std::size_t>(face::kShapeRegions[k])] += log_odds_[cell];
  }
  if (!table_->regions) return explained;
  scores = means(scores);
  for (std::size_t r = 0; r < scores.size(); ++r)
    out.region_confidence[r] = (*table_->regions)[r].at(scores[r]);
  return explained;
}

RegionScores ShapeConfidence::region_scores(const Coverage& coverage,
                                            const face::BlendshapeWeights& weights) const {
  RegionScores scores{};
  if (!table_) return scores;
  for (std::size_t k = 0; k < face::kShapeCount; ++k)
    scores[static_cast<std::size_t>(face::kShapeRegions[k])] +=
        log_odds_[cell_of(row_of(k, coverage[k]), weights[k])];
  return means(scores);
}

}  // namespace mien::tracker
