#pragma once

#include <string>

#include "mien/measure/evaluation.h"

namespace mien::measure {

/// What an evaluation was made with; printed beside the figures.
struct EvaluationContext {
  std::string face;      ///< Which face the errors are measured on.
  std::string model;     ///< File of the model.
  std::string devices;   ///< "lab", "device", or "mixed".
  int steps = 0;         ///< Denoising steps; 0: a causal model, which takes none.
  bool adapted = false;  ///< Whether the model was personalised on the take first.
  double adapt_s = 0;
};

/// "4 denoising steps", or "frame by frame" of a causal model.
[[nodiscard]] std::string asked_how(const EvaluationContext& context);

/// The one JSON object that `mien evaluate --json` prints (docs/reference/metrics.md). Curves are left out.
[[nodiscard]] std::string evaluation_json(const Evaluation& evaluation, const EvaluationContext& context);

}  // namespace mien::measure
