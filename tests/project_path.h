#pragma once

#include <string>

namespace mien {

/// A file of the project, absolute: its rigs, models, corpora. `path` begins at the project's root and may be
/// empty.
[[nodiscard]] std::string project_path(const std::string& path);

}  // namespace mien
