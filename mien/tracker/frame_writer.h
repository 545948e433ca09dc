#pragma once

#include <vector>

#include "mien/face/output_frame.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/model_input.h"
#include "mien/tracker/shape_confidence.h"

namespace mien::tracker {

/// What stands around a network's weights in an output frame. Immutable; performances may share one.
class FrameWriter {
 public:
  explicit FrameWriter(const model::ModelFile& file);

  /// Fills `out` but for its weights, which are read as they are shown: after any filter. Provenance and
  /// confidence: as ShapeConfidence has them, by the coverage of the sensors that are there; returns what
  /// they explain. Head: as in the features. Eyes: neutral. `input` has just encoded `features`. No
  /// allocation; under half a microsecond (docs/experiments/confidence.md).
  Explained write(const model::FeatureFrame& features, const ModelInput& input, face::OutputFrame& out) const;

  /// The share of present sensors, each weighted by the size of the ridge baseline's coefficients for the
  /// shape; 1 where all are there.
  [[nodiscard]] Coverage coverage(const ModelInput& input) const;

 private:
  /// Weight of each sensor for each shape, sensors x 53, row-major; a shape's weights add up to 1.
  std::vector<float> shares_;
  ShapeConfidence confidence_;
};

}  // namespace mien::tracker
