#pragma once

#include <string>
#include <vector>

#include "mien/measure/report.h"
#include "mien/study/confidence.h"

namespace mien::study {

/// Every row: what is called measured and how it follows the truth, calibration errors, the baseline's.
[[nodiscard]] measure::Table confidence_table(const std::vector<ConfidenceRow>& rows);

/// The reliability diagram, the rows, and what the sensors explain of each shape. `subtitle` says which model
/// answered.
[[nodiscard]] measure::Report confidence_report(const std::vector<ConfidenceRow>& rows,
                                                const model::ConfidenceTable& table,
                                                const std::string& subtitle);

}  // namespace mien::study
