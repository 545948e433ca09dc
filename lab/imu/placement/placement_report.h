#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lab/imu/placement/placement_study.h"
#include "mien/core/error.h"
#include "mien/measure/report.h"

namespace mien::lab {

/// Sets of each size by the linear bound, and the paper's beside them.
[[nodiscard]] measure::Table placement_sets_table(const PlacementStudy& study);

/// What whoever looks at the chosen set should know first, a sentence each: groups of shapes of which it
/// tells nothing, candidates that could not be chosen.
[[nodiscard]] std::vector<std::string> placement_remarks(const PlacementStudy& study);

/// The chosen sensors in their order: where, and what each tells alone.
[[nodiscard]] measure::Table placement_sites_table(const PlacementStudy& study);

/// What misplacing each sensor of a set costs; `set` names it in a sentence.
[[nodiscard]] measure::Table misplacement_table(std::string_view set,
                                                const std::vector<SiteMisplacement>& sites);

/// The candidates that are not of the grid: each alone.
[[nodiscard]] measure::Table placement_candidates_table(const PlacementStudy& study);

/// The paper's Table 2 beside what the same sites feel here.
[[nodiscard]] measure::Table placement_paper_table(const PlacementStudy& study);

/// Where both tables agree and where not.
[[nodiscard]] std::string placement_paper_words(const PlacementStudy& study);

/// What networks of each set are off, and how large their trainings were; without rows where none was
/// trained.
[[nodiscard]] measure::Table placement_trained_table(const PlacementStudy& study,
                                                     const PlacementTrainingRequest& request);

/// What the trainings say, a sentence each: which set is better, or that trainings so small compare
/// nothing; and which sets could not be trained. Empty where none was to be.
[[nodiscard]] std::vector<std::string> placement_verdicts(const PlacementStudy& study,
                                                          const PlacementRequest& request);

/// How to read all of it.
[[nodiscard]] std::string placement_legend(const PlacementRequest& request);

/// All tables and sentences for a terminal or a file.
[[nodiscard]] std::string placement_text(const PlacementStudy& study, const PlacementRequest& request);

/// The whole study on one page. Errors: those of the pictures' encoder.
[[nodiscard]] Result<measure::Report> placement_report(const PlacementStudy& study,
                                                       const PlacementRequest& request,
                                                       const std::string& subtitle);

}  // namespace mien::lab
