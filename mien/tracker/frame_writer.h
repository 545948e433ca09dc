#pragma once

#include <span>
#include <vector>

#include "mien/face/output_frame.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/model_input.h"

namespace mien::tracker {

/// Makes output frames of what a causal network answers. Immutable; any number of performances may share one.
class FrameWriter {
 public:
  explicit FrameWriter(const model::ModelFile& file);

  /// Fills all of `out` but the eyes, which become neutral ones: weights in [0, 1] from `answer`, the
  /// network's 53 numbers; provenance: measured where any sensor has a rotation, else predicted; confidence
  /// of a shape: the share of its sensors that were there, each counting as much as the file's ridge listens
  /// to it for that shape; the head's as the features say. `input` has just encoded `features`. No
  /// allocation.
  void write(const model::FeatureFrame& features, const ModelInput& input, std::span<const float> answer,
             face::OutputFrame& out) const;

 private:
  /// How much of what is known of a shape each sensor says: a sensor's 53 shares stand together, and a
  /// shape's add up to 1.
  std::vector<float> shares_;
};

}  // namespace mien::tracker
