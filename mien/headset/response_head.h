#pragma once

#include <cstddef>
#include <string_view>

#include "mien/core/error.h"

namespace mien::headset {

/// A camera's answer to GET, as far as it was agreed to.
struct ResponseHead {
  bool chunked = false;  ///< The body comes in chunks (chunked_body.h).
  bool operator==(const ResponseHead&) const = default;
};

/// Longer ones are no camera's.
inline constexpr std::size_t kMaxHeadBytes = std::size_t{8} << 10U;

/// Reads the head of an HTTP response, without the empty line behind it. Only a stream of pictures is taken:
/// status 200, type multipart/x-mixed-replace, as it is or in chunks. Errors, which say what to do:
/// malformed (no head of HTTP/1.0 or 1.1, control characters, a header twice); unsupported (a password, a
/// redirect, which is never followed, another status, type or coding); out_of_range (kMaxHeadBytes). No
/// allocation but in errors. Thread-safe.
[[nodiscard]] Result<ResponseHead> parse_response_head(std::string_view head);

}  // namespace mien::headset
