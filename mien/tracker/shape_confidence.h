#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/model/confidence.h"

namespace mien::tracker {

/// How much of what each shape is read from is there, 0 to 1.
using Coverage = std::array<float, face::kShapeCount>;

/// How much of each shape's variance a tracker's answer explains with the sensors that are there, 0 to 1,
/// measured on people whom its model never saw (model::ConfidenceTable). It changes with the sensors and not
/// with the weights, so trackers of one face can be compared by it.
using Explained = std::array<float, face::kShapeCount>;

/// One number a region, in the order of face::ShapeRegion.
using RegionScores = std::array<float, face::kShapeRegionCount>;

/// Whether a shape is one of the eight that say where the eyes look: only what looks at the eyes can measure
/// it.
[[nodiscard]] inline bool is_gaze(std::size_t shape) {
  return face::kShapeNames[shape].starts_with("eyeLook");
}

/// What a model's table says of a shape in a bin of coverage: measured where the sensors explain enough of
/// its variance, else predicted; gaze, which no sensor on the skin sees, is always predicted.
[[nodiscard]] inline face::Provenance provenance_of(const model::ConfidenceTable& table, std::size_t shape,
                                                    std::size_t coverage_bin) {
  return table.explained_by(shape, coverage_bin) >= table.measured_from && !is_gaze(shape)
             ? face::Provenance::measured
             : face::Provenance::predicted;
}

/// What a tracker says of its shapes and regions, by its model's table: the same of every kind of sensors.
/// Immutable; performances may share one.
class ShapeConfidence {
 public:
  /// No shape is surer of itself, or less sure, than this: a share of frames is known no better.
  static constexpr float kLeastProbability = 0.01F;

  /// Without a table nothing is measured or explained, and every confidence is 0.
  explicit ShapeConfidence(std::optional<model::ConfidenceTable> table);

  /// Fills provenance and confidence of the 53 shapes of `out`, whose weights are read as they are shown.
  /// Provenance: measured where the table says that sensors of this coverage explain enough of the shape's
  /// variance, else predicted; gaze, which no sensor on the skin sees, is always predicted. Confidence: the
  /// table's probability that the weight's error is at most model::kConfidenceTolerance. The regions'
  /// confidence: their map of region_scores(); 0 where the table has none. Returns what is explained. No
  /// allocation.
  Explained write(const Coverage& coverage, face::OutputFrame& out) const;

  /// What a region's map is fitted to and reads: the mean log-odds, ln(c / (1 - c)), of its shapes'
  /// confidences c, each held to kLeastProbability and 1 - kLeastProbability. Zeros without a table.
  [[nodiscard]] RegionScores region_scores(const Coverage& coverage,
                                           const face::BlendshapeWeights& weights) const;

 private:
  std::optional<model::ConfidenceTable> table_;
  /// Place in the table of what is said of a shape, of its coverage bin and of its weight's bin.
  [[nodiscard]] std::size_t row_of(std::size_t shape, float coverage) const;
  [[nodiscard]] std::size_t cell_of(std::size_t row, float weight) const;

  std::vector<face::Provenance> provenance_;  // Of each shape and coverage bin.
  std::vector<float> log_odds_;               // Of each of the table's shares within tolerance.
};

}  // namespace mien::tracker
