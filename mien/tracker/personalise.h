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

/// With fewer prompts than these nothing is learnt.
inline constexpr std::size_t kLeastPrompts = 6;

/// How well a wearer's skin was learnt, on prompts that it was not learnt from.
struct Personalisation {
  std::size_t frames = 0;   ///< That were learnt from.
  std::size_t prompts = 0;  ///< With at least one sensor there.
  /// Mean surprise of a held-out frame's rotations, given its prompt, as -log likelihood a sensor and axis in
  /// nats: of the standard skin, and of the learnt one.
  double surprise_before = 0, surprise_after = 0;
  bool taken = false;  ///< False: the learnt one was no better, and the model is as it was.
};

/// Learns how the wearer's skin turns under each sensor from a minute of prompted expressions, and puts it
/// into `file` (model::Skin::wearer). The prior is the standard skin, whatever wearer's the
/// file had; each slope may differ from it by about a half.
///
/// By expectation-maximisation over the frames of the prompts: weights and slopes are both unknown, weights
/// are known beforehand by the prompt, its usual lateness and how people miss it, slopes by the prior.
/// Prompts whose shapes others ask for too are held out first, up to a quarter of all, to see whether what
/// was learnt foretells them better; if it does, all are learnt from, else the file stays as it was.
///
/// `rig_sensors` names the features' sensors. Cost: a second or two of one core a minute of prompts. Errors:
/// unsupported (a model without a skin), not_found (fewer than six prompts with sensors, or none whose shapes
/// are asked for twice), mismatch (no sensor in common, outputs that are not the 53 shapes).
[[nodiscard]] Result<Personalisation> personalise(std::span<const model::FeatureFrame> features,
                                                  std::span<const PromptedExpression> prompts,
                                                  const std::vector<std::string>& rig_sensors,
                                                  model::ModelFile& file);

}  // namespace mien::tracker
