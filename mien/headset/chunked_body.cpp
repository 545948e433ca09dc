#include "mien/headset/chunked_body.h"

#include <algorithm>

#include "mien/core/ascii.h"

namespace mien::headset {
namespace {

const char* const kChunk = "HTTP chunk";
constexpr std::uint32_t kMostDigits = 7;  // 256 MB: no camera's.
/// Of extensions, which nobody sends.
constexpr std::uint32_t kMostExtra = 128;

std::unexpected<Error> bad_chunk(const char* what) {
  return fail(ErrorCode::malformed, what, kChunk, "restart the camera");
}

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  c = ascii_lower(c);
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

}  // namespace

Result<void> ChunkedBody::add_to_frame(char c) {
  if (at_ == At::content_end) {
    if (c == '\r') return {};
    if (c != '\n') return bad_chunk("it does not end where it was to end");
    at_ = At::length;
    left_ = digits_ = extra_ = 0;
    return {};
  }
  if (at_ == At::length) {
    if (const int digit = digit_of(c); digit >= 0) {
      if (++digits_ > kMostDigits) return bad_chunk("it is longer than 256 MB");
      left_ = 16 * left_ + static_cast<std::uint32_t>(digit);
      return {};
    }
    if (digits_ == 0) return bad_chunk("its length is no number");
    at_ = At::extension;
    if (c != '\r' && c != '\n' && c != ';' && c != ' ') return bad_chunk("its length is no number");
  }
  if (c != '\n')
    return ++extra_ > kMostExtra ? Result<void>(bad_chunk("its length has no end")) : Result<void>();
  if (left_ == 0) return fail(ErrorCode::not_found, "the camera ended its stream", kChunk);
  at_ = At::content;
  return {};
}

Result<std::span<const std::byte>> ChunkedBody::read(std::span<const std::byte>& bytes) {
  while (!bytes.empty()) {
    if (at_ == At::content) {
      const auto content = bytes.first(std::min<std::size_t>(left_, bytes.size()));
      bytes = bytes.subspan(content.size());
      left_ -= static_cast<std::uint32_t>(content.size());
      if (left_ == 0) at_ = At::content_end;
      return content;
    }
    const auto c = std::to_integer<char>(bytes.front());
    bytes = bytes.subspan(1);
    MIEN_TRY(add_to_frame(c));
  }
  return std::span<const std::byte>();
}

}  // namespace mien::headset
