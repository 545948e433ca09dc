#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"

namespace mien {

/// Largest file that read_file takes unless told otherwise: 2 GiB.
inline constexpr std::size_t kMaxFileBytes = std::size_t{1} << 31U;

/// The whole file. Errors: not_found, io, out_of_range (larger than `max_bytes`).
[[nodiscard]] Result<std::vector<std::byte>> read_file(const std::filesystem::path& path,
                                                       std::size_t max_bytes = kMaxFileBytes);
/// The same as text; no conversion of line ends.
[[nodiscard]] Result<std::string> read_text(const std::filesystem::path& path,
                                            std::size_t max_bytes = kMaxFileBytes);

/// Writes to a new file beside `path`, flushes it to the disk and renames it: readers see the old content or
/// the new, never half. A link stays a link; a pipe or device is written straight into.
/// Errors: bad_usage (a folder), not_found (its folder is not there), io, with the reason (disk full, no
/// permission).
[[nodiscard]] Result<void> write_file(const std::filesystem::path& path, std::span<const std::byte> bytes);
[[nodiscard]] Result<void> write_file(const std::filesystem::path& path, std::string_view text);

/// The running program's real path. Errors: io.
[[nodiscard]] Result<std::filesystem::path> running_program();

/// Where a program's own parts stand (models, rigs, helpers): found from the running program's real path, in
/// an installed tree as in a build tree. `relative` is like "rigs/default.toml". Errors: not_found.
[[nodiscard]] Result<std::filesystem::path> find_resource(const std::filesystem::path& relative);

/// Where this program keeps what it can make anew: $XDG_CACHE_HOME/mien, else ~/.cache/mien. It need not be
/// there. Empty where the user has no home.
[[nodiscard]] std::filesystem::path cache_folder();

}  // namespace mien
