#pragma once

#include <array>
#include <optional>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/model_input.h"

namespace mien::tracker {

/// How much of what each shape is read from is there, 0 to 1.
using Coverage = std::array<float, face::kShapeCount>;

/// What stands around a network's weights in an output frame. Immutable; performances may share one.
class FrameWriter {
 public:
  explicit FrameWriter(const model::ModelFile& file);

  /// Fills `out` but for its weights, which are read as they are shown: after any filter. Provenance:
  /// measured where the model's table says that sensors as these explain enough of the shape's variance, else
  /// predicted; gaze, which no sensor on the skin sees, is always predicted. Confidence: the table's
  /// probability that the weight's error is at most model::kConfidenceTolerance. Without a table all is
  /// predicted with confidence 0. Head: as in the features. Eyes: neutral. `input` has just encoded
  /// `features`. No allocation; under half a microsecond (bench/frame_writer_bench.cpp).
  void write(const model::FeatureFrame& features, const ModelInput& input, face::OutputFrame& out) const;

  /// The share of present sensors, each weighted by the size of the ridge baseline's coefficients for the
  /// shape; 1 where all are there.
  [[nodiscard]] Coverage coverage(const ModelInput& input) const;

 private:
  /// Weight of each sensor for each shape, sensors x 53, row-major; a shape's weights add up to 1.
  std::vector<float> shares_;
  std::optional<model::ConfidenceTable> table_;
  /// Of each shape and coverage bin.
  std::vector<face::Provenance> provenance_;
};

}  // namespace mien::tracker
