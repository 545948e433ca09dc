#pragma once

#include <string>

#include "lab/columns.h"
#include "lab/imu/loss.h"
#include "mien/measure/report.h"

namespace mien::lab {

/// The figures of a condition.
[[nodiscard]] const Columns<LossRow>& loss_columns();

/// The study as people read it: what is promised and what came out, the curve of accuracy against loss, every
/// condition, and every sensor. `subtitle` says who performed and which model answered.
[[nodiscard]] measure::Report loss_report(const LossStudy& study, const std::string& subtitle);

}  // namespace mien::lab
