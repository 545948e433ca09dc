#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/face/livelink_csv.h"
#include "mien/face/motion.h"

namespace mien::face {

/// The performance in a Live Link Face CSV, named after its file. Errors: not_found, io, and those of
/// parse_livelink_csv.
[[nodiscard]] Result<LiveLinkMotion> load_livelink(const std::filesystem::path& path);
/// Its motion alone. `warnings`, where given, tells what was survived. Errors: the same.
[[nodiscard]] Result<Motion> load_motion(const std::filesystem::path& path,
                                         std::vector<std::string>* warnings = nullptr);

}  // namespace mien::face
