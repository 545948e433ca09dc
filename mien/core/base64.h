#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace mien {

/// Bytes as base64 with padding (RFC 4648, section 4), for data inside text files.
[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

}  // namespace mien
