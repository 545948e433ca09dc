#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "app/json_output.h"
#include "lab/imu/hours_study.h"
#include "lab/imu/hours_summary.h"

namespace mien::lab {

/// Figures with all their digits.
[[nodiscard]] app::Json hours_json(const HoursErrors& errors);
[[nodiscard]] app::Json hours_json(const HoursRun& run);
[[nodiscard]] app::Json hours_json(const HoursSummary& summary);
/// Errors: malformed.
[[nodiscard]] Result<HoursRun> parse_hours_run(std::string_view text, const std::string& where);

/// Keeps each run's figures as a file of JSON in `folder`, which is made where it is not. Its name is a hash
/// of the run's key, the rig's and the model's bytes and this program's own. A file that cannot be read is
/// made anew. Errors: those of reading the rig, the model and the program; io (the folder).
[[nodiscard]] Result<HoursCache> hours_cache(const std::filesystem::path& folder,
                                             const std::filesystem::path& rig,
                                             const std::filesystem::path& model);

}  // namespace mien::lab
