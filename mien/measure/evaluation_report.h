#pragma once

#include "mien/measure/evaluation.h"
#include "mien/measure/evaluation_json.h"
#include "mien/measure/report.h"

namespace mien::measure {

/// Where the eyes looked, how far lids and lips were apart, and what the confidence was worth, beside the
/// baselines: columns that hold something. Without rows where nothing of it is known.
[[nodiscard]] Table eyes_and_lips_table(const Evaluation& evaluation);

/// Errors about each shape's own rest (MotionErrors), beside the baselines. Without rows where they were not
/// measured.
[[nodiscard]] Table motion_table(const Evaluation& evaluation);

/// The model over several wears. Without rows where it was worn once.
[[nodiscard]] Table wears_table(const Evaluation& evaluation);

/// An evaluation as people read it: key figures, the table beside its baselines, errors frame by frame, and
/// every shape's error and correlation. More parts may be added to what it returns.
[[nodiscard]] Report evaluation_report(const Evaluation& evaluation, const EvaluationContext& context);

}  // namespace mien::measure
