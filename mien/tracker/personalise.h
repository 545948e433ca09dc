#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/model/features.h"
#include "mien/model/model_file.h"
#include "mien/tracker/prompted_expression.h"

namespace mien::tracker {

/// Least number of prompts with sensors for learning.
inline constexpr std::size_t kLeastPrompts = 6;

/// Result of learning a wearer's skin, evaluated on held-out prompts.
struct Personalisation {
  std::size_t frames = 0;   ///< Frames of prompts that were used.
  std::size_t prompts = 0;  ///< Prompts with at least one sensor present.
  /// Mean negative log likelihood of held-out rotations given their prompt, nats per sensor and axis: with
  /// the standard skin, and with the learnt one. Lower is better.
  double surprise_before = 0, surprise_after = 0;
  bool taken = false;  ///< False: the learnt skin was no better; the model is unchanged.
};

/// Learns the wearer's slopes (rotation vector of each sensor per unit weight, frame H, rad) from a minute of
/// prompted expressions, and stores them in `file` (model::Skin::wearer), whose correction, if any, goes. The
/// prior is the standard skin, whatever wearer the file had, with a standard deviation of 10 to 50 % of each
/// slope. Method: docs/method/personalisation.md.
///
/// Expectation-maximisation over the frames of the prompts: weights and slopes are both unknown, with priors
/// from the prompt (usual latency, gain and unasked shapes) and from the standard skin. Prompts whose shapes
/// others ask for too are held out first, up to a quarter of all; if the learnt slopes predict them better,
/// all prompts are learnt from, else the file stays as it was.
///
/// `rig_sensors`: names of the features' entries. Cost: a second or two of one core a minute of prompts.
/// Errors: unsupported (a model without a skin), not_found (fewer than six prompts with sensors, or none
/// whose shapes are asked for twice), mismatch (no sensor in common, outputs that are not the 53 shapes).
[[nodiscard]] Result<Personalisation> personalise(std::span<const model::FeatureFrame> features,
                                                  std::span<const PromptedExpression> prompts,
                                                  const std::vector<std::string>& rig_sensors,
                                                  model::ModelFile& file);

}  // namespace mien::tracker
