#pragma once

#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/output_frame.h"
#include "mien/model/denoiser.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"

namespace mien::tracker {

/// Offline solver: a whole track of features to output frames by the published window network
/// (docs/method/window_model.md). Immutable after creation; threads may share one.
class WindowSolver {
 public:
  /// Errors: mismatch (a model whose outputs are not the 53 shapes), and the denoiser's.
  [[nodiscard]] static Result<WindowSolver> create(model::ModelFile file,
                                                   model::Precision precision = model::Precision::fp32);

  [[nodiscard]] const model::ModelFile& file() const { return file_; }

  /// One output frame per frame of features, at 60 Hz. `sensors`: names of the features' entries; sensors of
  /// the model that are not among them are missing. Provenance, confidence and head: as FrameWriter has
  /// them. Eyes stay neutral. Errors: mismatch (no sensor in common), the sampler's.
  [[nodiscard]] Result<std::vector<face::OutputFrame>> solve(std::span<const model::FeatureFrame> features,
                                                             const std::vector<std::string>& sensors,
                                                             const model::SamplerSettings& settings,
                                                             const Progress& progress) const;

 private:
  WindowSolver(model::ModelFile file, model::Denoiser denoiser);

  model::ModelFile file_;
  model::Denoiser denoiser_;
};

}  // namespace mien::tracker
