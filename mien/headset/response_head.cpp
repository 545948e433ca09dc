#include "mien/headset/response_head.h"

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

}  // namespace mien::headset
