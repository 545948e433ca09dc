#pragma once

#include "mien/face/output_frame.h"
#include "mien/model/features.h"

namespace mien::tracker {

/// What turns features into an answer frame by frame, with nothing of the future: the live model, whatever
/// network is behind it.
class FrameModel {
 public:
  virtual ~FrameModel() = default;
  /// One frame of the grid; frames come in order, one for each index. Fills every field of `out` but the
  /// eyes. No allocation.
  virtual void step(const model::FeatureFrame& features, face::OutputFrame& out) = 0;
  /// Forgets what came before.
  virtual void reset() = 0;
};

}  // namespace mien::tracker
