#pragma once

#include <string>
#include <vector>

#include "mien/measure/evaluation.h"

namespace mien::measure {

/// What another tracker told of a take's face, where its weights stand for the truth.
struct ToldTruth {
  std::string take;      ///< The file, as it was named.
  std::string by;        ///< The rig's name of the phone, or its file's.
  double agreement = 0;  ///< Share of jaw and smile that the skin foretells (phone::TimeAlignment).
  double offset_ms = 0;  ///< When it began, after the take's first frame, in the middle of both.
  double offset_sigma_ms = 0;
  double known_s = 0;       ///< With a face, after the calibration.
  bool rest_known = false;  ///< It saw the neutral face, and what it told then is taken off.
};

/// What an evaluation was made with; printed beside the figures.
struct EvaluationContext {
  std::string face;      ///< Which face the errors are measured on.
  std::string model;     ///< File of the model.
  std::string devices;   ///< "lab", "device", or "mixed".
  int steps = 0;         ///< Denoising steps; 0: a causal model, which takes none.
  bool adapted = false;  ///< Whether the model was personalised on the take first.
  double adapt_s = 0;
  std::vector<ToldTruth> told = {};  ///< Of each take; empty: each take's own truth.
  /// Performances of the takes that the model was trained on: their errors are no measure of new people.
  std::vector<std::string> trained_on = {};
};

/// "4 denoising steps", or "frame by frame" of a causal model.
[[nodiscard]] std::string asked_how(const EvaluationContext& context);

/// What limits the figures' meaning, a sentence each: truth that other trackers told, performances that the
/// model was trained on. Empty where there is nothing of it.
[[nodiscard]] std::vector<std::string> caveats(const EvaluationContext& context);

/// The one JSON object that `mien evaluate --json` prints (docs/reference/metrics.md). Curves are left out.
[[nodiscard]] std::string evaluation_json(const Evaluation& evaluation, const EvaluationContext& context);

}  // namespace mien::measure
