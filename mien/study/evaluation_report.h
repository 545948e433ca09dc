#pragma once

#include "mien/study/evaluation.h"
#include "mien/study/evaluation_json.h"
#include "mien/study/report.h"

namespace mien::study {

/// An evaluation as people read it: key figures, the table beside its baselines, errors frame by frame, and
/// every shape's error and correlation. More parts may be added to what it returns.
[[nodiscard]] Report evaluation_report(const Evaluation& evaluation, const EvaluationContext& context);

}  // namespace mien::study
