#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace mien {

/// Bytes as base64 with padding (RFC 4648, section 4), for data inside text files.
[[nodiscard]] std::string base64(std::span<const std::byte> bytes);

/// Bytes as lower-case hexadecimal digits, two each (RFC 4648, section 8, but for the case).
[[nodiscard]] std::string hex(std::span<const std::byte> bytes);

}  // namespace mien
