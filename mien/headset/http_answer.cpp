#include "mien/headset/http_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "mien/core/ascii.h"
#include "mien/core/excerpt.h"

namespace mien::headset {
namespace {

const char* const kHead = "HTTP answer";
const char* const kGiveStream = "give the address of its MJPEG stream, http://HOST:PORT/PATH";
constexpr std::string_view kPictures = "multipart/x-mixed-replace";

/// The text up to the line's end, CR LF or LF, which is taken from the front of `rest` with it.
std::string_view take_line(std::string_view& rest) {
  const std::size_t end = rest.find('\n');
  std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

Result<void> check_status(std::string_view line) {
  int status = 0;
  if (line.starts_with("HTTP/1.1 ") || line.starts_with("HTTP/1.0 ")) {
    const std::string_view number = line.substr(9, 3);
    const auto [end, wrong] = std::from_chars(number.data(), number.data() + number.size(), status);
    const bool ends = line.size() == 12 || (line.size() > 12 && line[12] == ' ');
    if (wrong != std::errc{} || end != number.data() + 3 || !ends) status = 0;
  }
  if (status == 200) return {};
  if (status < 100)
    return fail(ErrorCode::malformed, fmt::format("\"{}\" is no answer of a camera", excerpt(line)), kHead,
                kGiveStream);
  if (status == 401 || status == 403 || status == 407)
    return fail(ErrorCode::unsupported, fmt::format("the camera wants a password ({})", status), kHead,
                "switch its password off; none is ever sent");
  if (status >= 300 && status < 400)
    return fail(ErrorCode::unsupported, fmt::format("the camera points to another address ({})", status),
                kHead, "give that address; redirects are not followed");
  if (status == 404)
    return fail(ErrorCode::unsupported, "the camera has no such path (404)", kHead, kGiveStream);
  return fail(ErrorCode::unsupported, fmt::format("the camera answers {} instead of 200", status), kHead,
              "restart the camera, and look whether another program has its stream");
}

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

Result<ResponseHead> parse_response_head(std::string_view head) {
  if (head.size() > kMaxHeadBytes)
    return fail(ErrorCode::out_of_range, fmt::format("a head of over {} bytes", kMaxHeadBytes), kHead,
                kGiveStream);
  MIEN_TRY(check_status(take_line(head)));
  std::optional<std::string_view> type;
  std::optional<std::string_view> transfer;
  std::optional<std::string_view> coding;
  const std::array<std::pair<std::string_view, std::optional<std::string_view>*>, 3> read = {
      {{"content-type", &type}, {"transfer-encoding", &transfer}, {"content-encoding", &coding}}};
  while (!head.empty()) {
    const std::string_view line = take_line(head);
    const std::size_t colon = line.find(':');
    const bool odd = std::ranges::any_of(
        line, [](char c) { return (static_cast<unsigned char>(c) < ' ' && c != '\t') || c == '\x7f'; });
    if (odd || colon == std::string_view::npos || colon == 0 || line.front() == ' ' || line.front() == '\t')
      return fail(ErrorCode::malformed, fmt::format("\"{}\" is no header", excerpt(line)), kHead,
                  kGiveStream);
    const std::string_view name = line.substr(0, colon);
    const std::string_view value = trimmed(line.substr(colon + 1));
    for (const auto& [asked, place] : read) {
      if (!equal_ignoring_case(name, asked)) continue;
      if (*place)
        return fail(ErrorCode::malformed, fmt::format("{} stands twice", asked), kHead, kGiveStream);
      *place = value;
    }
  }
  if (!type) return fail(ErrorCode::unsupported, "it does not say what is sent", kHead, kGiveStream);
  if (!equal_ignoring_case(trimmed(type->substr(0, type->find(';'))), kPictures))
    return fail(ErrorCode::unsupported, fmt::format("\"{}\" and no stream of pictures", excerpt(*type)),
                kHead, kGiveStream);
  if (coding && !equal_ignoring_case(*coding, "identity"))
    return fail(ErrorCode::unsupported, fmt::format("pictures in the coding \"{}\"", excerpt(*coding)), kHead,
                "switch compression off, in the camera or in what stands before it");
  if (!transfer) return ResponseHead{};
  if (!equal_ignoring_case(*transfer, "chunked"))
    return fail(ErrorCode::unsupported, fmt::format("a transfer as \"{}\"", excerpt(*transfer)), kHead,
                "let the camera send its stream as it is, or in chunks");
  return ResponseHead{.chunked = true};
}

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
