#pragma once

#include <span>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/model_input.h"

namespace mien::tracker {

/// Makes output frames from a causal network's outputs. Immutable; performances may share one.
class FrameWriter {
 public:
  explicit FrameWriter(const model::ModelFile& file);

  /// Fills `out`. Weights: `answer`, the network's 53 outputs, mapped to [0, 1]. Provenance: measured where
  /// any sensor has a rotation, else predicted; of gaze, which no sensor on the skin sees, always predicted.
  /// Confidence of a shape, 0 to 1: the share of present sensors,
  /// each weighted by the size of the ridge baseline's coefficients for that shape. Head: as in the features.
  /// Eyes: neutral. `input` has just encoded `features`. No allocation.
  void write(const model::FeatureFrame& features, const ModelInput& input, std::span<const float> answer,
             face::OutputFrame& out) const;

 private:
  /// Weight of each sensor for each shape, sensors x 53, row-major; a shape's weights add up to 1.
  std::vector<float> shares_;
};

}  // namespace mien::tracker
