#pragma once

#include <vector>

#include "mien/core/error.h"
#include "mien/face/output_frame.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/shape_confidence.h"

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

  /// Whether this, learnt for a wearer (learn_correction()), belongs to its network. Errors: unsupported (its
  /// answers are not corrected), mismatch (it was learnt for another network).
  [[nodiscard]] virtual Result<void> check_correction(
      [[maybe_unused]] const model::Correction& correction) const {
    return fail(ErrorCode::unsupported, "nothing here is corrected for its wearer", "session",
                "use a live model, such as models/live.safetensors");
  }
  /// Its answers are corrected by this from now on; none: by what its file came with. Only what
  /// check_correction() allows.
  virtual void use_correction([[maybe_unused]] const model::Correction* correction) {}
};

}  // namespace mien::tracker
