#pragma once

#include <filesystem>

namespace mien {

/// Where this program keeps what it can make anew: $XDG_CACHE_HOME/mien, else ~/.cache/mien. It need not be
/// there. Empty where the user has no home.
[[nodiscard]] std::filesystem::path cache_folder();

}  // namespace mien
