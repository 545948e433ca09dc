#pragma once

#include <optional>
#include <string>

#include "lab/imu/ablation/ablation_study.h"
#include "mien/core/error.h"
#include "mien/measure/report.h"

namespace mien::lab {

/// How much more a row is off than the base on one test set, as a share of the base's figure, with 95 %
/// confidence; nothing for the base itself, for a model of one training, and where it was not tried.
[[nodiscard]] std::optional<Interval> change_of(const AblationStudy& study, const AblationResult& row,
                                                TestSet set,
                                                SeedFigures SeedErrors::*measure = &SeedErrors::pve_mm);

/// The rows beside each other on one test set; without rows where nobody was tried there.
[[nodiscard]] measure::Table ablation_table(const AblationStudy& study, TestSet set);
/// The change that fewer sensors and less data make: here, by the linear bound, and in CAPUS's Table 1.
[[nodiscard]] measure::Table beside_the_paper(const AblationStudy& study);
/// What the tables' columns mean.
[[nodiscard]] std::string ablation_legend(const AblationStudy& study);

/// The whole study as people read it. Errors: moments_strip's.
[[nodiscard]] Result<measure::Report> ablation_report(const AblationStudy& study,
                                                      const std::string& subtitle);

}  // namespace mien::lab
