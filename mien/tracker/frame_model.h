#pragma once

#include <vector>

#include "mien/face/output_frame.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/explained.h"

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

  /// What the last frame's sensors explain; none where nobody measured what the model is worth.
  [[nodiscard]] virtual const Explained* explained() const { return nullptr; }

  /// The model file, where a wearer can be learnt for it (personalise()); else none.
  [[nodiscard]] virtual const model::ModelFile* personal() const { return nullptr; }
  /// From now on it reads what comes by this wearer's skin (model::Skin::wearer); empty: by the one that its
  /// file came with. Only where personal() is something, and of its skin's size.
  virtual void use_wearer([[maybe_unused]] const std::vector<float>& slopes) {}

  /// Whether its answers can be corrected for a wearer (learn_correction()).
  [[nodiscard]] virtual bool corrects() const { return false; }
  /// From now on they are, by this; none: by what its file came with. Only where corrects().
  virtual void use_correction([[maybe_unused]] const model::Correction* correction) {}
};

}  // namespace mien::tracker
