#pragma once

#include <string>

#include "mien/dataset/export_windows.h"

namespace mien::dataset {

/// What an export holds and where it comes from, as Markdown, by the questions of Gebru et al. 2021,
/// "Datasheets for datasets" (doi:10.1145/3458723). Depends on nothing but the two, and holds nothing that a
/// reader of Markdown would obey.
[[nodiscard]] std::string datasheet_of(const ExportRequest& request, const Export& exported);

}  // namespace mien::dataset
