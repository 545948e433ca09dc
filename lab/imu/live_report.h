#pragma once

#include <string>

#include "lab/imu/live_study.h"
#include "mien/measure/report.h"

namespace mien::lab {

/// A set's rows as one table: each condition a strong row that says how well was sensed, then its methods,
/// each figure as mean ± standard deviation over performers.
[[nodiscard]] measure::Table live_table(const LiveSet& set);

/// What stands in the page and beside the table: how to read it.
[[nodiscard]] std::string live_legend();

/// The whole study on one page: for each set its figures, a plot of the vertex error for each group of
/// conditions, and the table.
[[nodiscard]] measure::Report live_report(const LiveStudy& study, const std::string& subtitle);

}  // namespace mien::lab
