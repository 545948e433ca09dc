#pragma once

#include <string>
#include <vector>

#include "mien/measure/report.h"
#include "mien/synthetic/confidence.h"

namespace mien::lab {

/// The reliability diagram, the rows (study_confidence), the faults' (study_faults), the same of regions
/// where the table has maps, and what the sensors explain of each shape. `subtitle` says which model
/// answered.
[[nodiscard]] measure::Report confidence_report(const std::vector<synthetic::ConfidenceRow>& rows,
                                                const std::vector<synthetic::ConfidenceRow>& faults,
                                                const model::ConfidenceTable& table,
                                                const std::string& subtitle);

}  // namespace mien::lab
