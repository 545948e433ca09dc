#pragma once

#include <array>
#include <optional>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/model/confidence.h"
#include "mien/tracker/explained.h"

namespace mien::tracker {

/// How much of what each shape is read from is there, 0 to 1.
using Coverage = std::array<float, face::kShapeCount>;

/// What a tracker says of its shapes, by its model's table: the same of every kind of sensors. Immutable;
/// performances may share one.
class ShapeConfidence {
 public:
  /// Without a table nothing is measured or explained, and every confidence is 0.
  explicit ShapeConfidence(std::optional<model::ConfidenceTable> table);

  /// Fills provenance and confidence of the 53 shapes of `out`, whose weights are read as they are shown.
  /// Provenance: measured where the table says that sensors of this coverage explain enough of the shape's
  /// variance, else predicted; gaze, which no sensor on the skin sees, is always predicted. Confidence: the
  /// table's probability that the weight's error is at most model::kConfidenceTolerance. Returns what is
  /// explained. No allocation.
  Explained write(const Coverage& coverage, face::OutputFrame& out) const;

 private:
  std::optional<model::ConfidenceTable> table_;
  std::vector<face::Provenance> provenance_;  // Of each shape and coverage bin.
};

}  // namespace mien::tracker
