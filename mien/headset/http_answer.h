#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "mien/core/error.h"

namespace mien::headset {

/// A camera's answer to GET, as far as it was agreed to.
struct ResponseHead {
  bool chunked = false;  ///< The body comes in chunks (ChunkedBody).
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

/// The content of an HTTP body that comes in chunks (RFC 9112, section 7.1), as the boards' web server sends
/// every stream. Keeps nothing of it, so a length that lies costs no memory. No allocation but in errors.
class ChunkedBody {
 public:
  void restart() { *this = {}; }
  /// Reads from the front of `bytes`, which is moved behind what was read: the next content, a part of it;
  /// empty when all was read. Errors: malformed (a length that is no hexadecimal number, or has over 7
  /// digits; a chunk without its end); not_found (the last chunk: the stream is over). Nothing may be read
  /// then before restart().
  [[nodiscard]] Result<std::span<const std::byte>> read(std::span<const std::byte>& bytes);

 private:
  enum class At : std::uint8_t { length, extension, content, content_end };
  Result<void> add_to_frame(char c);

  At at_ = At::length;
  std::uint32_t left_ = 0;    // Of the chunk, while it is read.
  std::uint32_t digits_ = 0;  // Of its length, ...
  std::uint32_t extra_ = 0;   // ... and what stands behind it.
};

}  // namespace mien::headset
