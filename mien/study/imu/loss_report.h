#pragma once

#include <string>

#include "mien/measure/report.h"
#include "mien/study/imu/loss.h"

namespace mien::study {

/// The study as people read it: what is promised and what came out, the curve of accuracy against loss, every
/// condition, and every sensor. `subtitle` says who performed and which model answered.
[[nodiscard]] measure::Report loss_report(const LossStudy& study, const std::string& subtitle);

}  // namespace mien::study
