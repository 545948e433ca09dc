#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"

namespace mien::tracker {

/// What somebody else measured of the face at one frame.
struct TaughtFrame {
  bool known = false;
  face::BlendshapeWeights weights;  ///< 0 to 1.
};

/// What a correction is worth, by cross-validation over stretches of the take.
struct LearntCorrection {
  std::size_t frames = 0;  ///< That were known.
  std::size_t shapes = 0;  ///< That are corrected; the others were foretold no better.
  /// Mean squared error of the 53 weights, and mean over frames of the vertices' root mean square error, mm:
  /// of what was held out, with all sensors as they were worn.
  double mse_before = 0, mse_after = 0;
  double skin_before_mm = 0, skin_after_mm = 0;
  bool taken = false;  ///< False: it was no better; the model is unchanged.
};

/// Least time that must be known, s.
inline constexpr double kLeastTaughtS = 10;

/// Learns what a live model's answers lack for one wearer (model::Correction), and stores it in `file`: a
/// ridge regression of what was taught less the answer, on what the network's output layer reads. So that it
/// survives another day and a lost sensor, it is fitted to what the network sees of the same performance with
/// each sensor missing in turn and with all worn anew (WornAnew) as well. Ridge by cross-validation over
/// eight stretches, by the weights' error and the skin's alike; a shape is corrected where that makes its own
/// error smaller. What is in the file already is not built upon. Method: docs/method/phone_truth.md.
///
/// Shapes: `taught` one a frame of features; `features` as a take gives them, one a sixtieth of a second;
/// `rig_sensors`: names of their entries. `face`: whose skin counts. Cost: 13 s of one core and 60 MB
/// for two minutes. Errors: unsupported (a model that is not causal), not_found (less than kLeastTaughtS
/// known), mismatch (as CausalTracker::create), cancelled.
[[nodiscard]] Result<LearntCorrection> learn_correction(std::span<const model::FeatureFrame> features,
                                                        std::span<const TaughtFrame> taught,
                                                        const std::vector<std::string>& rig_sensors,
                                                        const face::Face& face, model::ModelFile& file,
                                                        const Progress& progress = no_progress);

}  // namespace mien::tracker
