#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/shape_region.h"

namespace mien::model {

/// A shape's confidence is the probability that its absolute error is at most this; weights are 0 to 1.
inline constexpr float kConfidenceTolerance = 0.1F;

/// Bins are few: a lookup compares with every edge.
inline constexpr std::size_t kMostConfidenceBins = 16;

/// Logistic regression of one score: the probability 1 / (1 + exp(-(offset + slope * score))).
struct LogisticMap {
  float offset = 0, slope = 0;
  bool operator==(const LogisticMap&) const = default;

  /// Each parameter is within these, either way: beyond them the sum could be no number.
  static constexpr float kLargest = 1e6F;
  [[nodiscard]] float at(float score) const;
};

/// Of each face::ShapeRegion: from its score in a frame (tracker::ShapeConfidence::region_scores) to the
/// probability that the mean absolute error of its shapes is at most kConfidenceTolerance.
using RegionMaps = std::array<LogisticMap, face::kShapeRegionCount>;

/// What a model is worth, shape by shape, measured on people it was not trained on
/// (docs/reference/metrics.md, "Confidence"). A shape's *coverage*, 0 to 1, is how much of what it is read
/// from is there (tracker::FrameWriter); a set of sensors counts by the coverage that it leaves each shape.
struct ConfidenceTable {
  /// Where a new bin of coverage begins, ascending, in (0, 1]; C - 1 of them. Likewise of the weight that the
  /// tracker gives, in (0, 1); V - 1.
  std::vector<float> coverage_edges, value_edges;
  /// Share of the truth's variance that the answer explains, 1 - squared error / variance, 0 to 1: shapes x
  /// C, row-major. Never larger at less coverage.
  std::vector<float> explained;
  /// Share of the frames whose error was at most kConfidenceTolerance, 0 to 1: shapes x C x V, row-major.
  std::vector<float> within;
  /// From this explained share on a shape is measured, below it predicted; 0 to 1. Raising: fewer shapes are
  /// called measured, each more surely. Chosen on the same people (synthetic::measure_confidence).
  float measured_from = 1;
  /// None (older files): nobody measured the regions.
  std::optional<RegionMaps> regions;
  std::size_t people = 0;  ///< Whom it was measured on.
  std::uint64_t seed = 0;  ///< What they were drawn from.
  bool operator==(const ConfidenceTable&) const = default;

  [[nodiscard]] std::size_t coverage_bins() const { return coverage_edges.size() + 1; }
  [[nodiscard]] std::size_t value_bins() const { return value_edges.size() + 1; }
  /// The explained share of a shape in a bin of coverage.
  [[nodiscard]] float explained_by(std::size_t shape, std::size_t coverage_bin) const {
    return explained[shape * coverage_bins() + coverage_bin];
  }
};

/// The bin of a value: the number of edges that it reaches.
[[nodiscard]] inline std::size_t confidence_bin(std::span<const float> edges, float value) {
  std::size_t bin = 0;
  for (const float edge : edges) bin += value >= edge ? 1 : 0;
  return bin;
}

/// Whether it holds together for so many shapes. Errors: mismatch (sizes), out_of_range (edges that do not
/// ascend, shares outside 0 to 1, a share that grows as coverage shrinks, a region's map beyond
/// LogisticMap::kLargest).
[[nodiscard]] Result<void> check(const ConfidenceTable& table, std::size_t shapes, const std::string& where);

}  // namespace mien::model
