#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/face/ict_import.h"

namespace mien::face {

/// Identifies the files that a cache was made of: SHA-256 over their paths, sizes and times of change, as
/// text.
[[nodiscard]] std::string fingerprint(std::span<const std::filesystem::path> files);

/// Where the cache of `folder` stands, or an empty path where there is no home to keep it in.
[[nodiscard]] std::filesystem::path cache_path(const std::filesystem::path& folder,
                                               const IctOptions& options);

/// The model as bytes: magic, version, fingerprint, content, CRC-32 of all before.
[[nodiscard]] std::vector<std::byte> encode_cache(const IctModel& model, std::string_view key);
/// The model again, or nothing where the bytes are damaged, of another version, or not made of `key`'s files.
[[nodiscard]] std::optional<IctModel> decode_cache(std::span<const std::byte> bytes, std::string_view key);

}  // namespace mien::face
