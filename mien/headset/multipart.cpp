#include "mien/headset/multipart.h"

#include <algorithm>
#include <charconv>
#include <chrono>

#include "mien/core/ascii.h"
#include "mien/core/bytes.h"

namespace mien::headset {
namespace {

constexpr std::uint32_t kPictureBegins = 0xFFD8FF;
constexpr std::array kFirstBytes = {std::byte{0xFF}, std::byte{0xD8}, std::byte{0xFF}};
/// Before the beginning of a picture, how far back the lines of its part are looked for where a broken one
/// took them for its own. The boards' have 130 bytes.
constexpr std::size_t kLinesBack = 512;
constexpr std::string_view kTimestamp = "x-timestamp:";
constexpr std::uint64_t kTimesBeginAnew = 100'000'000;  // Seconds.

}  // namespace

std::optional<DeviceTime> parse_timestamp(std::string_view text) {
  const char* const end = text.data() + text.size();
  std::uint64_t seconds = 0;
  const auto [point, wrong] = std::from_chars(text.data(), end, seconds);
  if (wrong != std::errc{}) return std::nullopt;
  std::uint64_t microseconds = 0;
  if (point != end) {
    const std::string_view digits(point + 1, end);
    const bool all_digits = std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; });
    if (*point != '.' || digits.empty() || digits.size() > 6 || !all_digits) return std::nullopt;
    std::from_chars(digits.data(), end, microseconds);
    for (std::size_t i = digits.size(); i < 6; ++i) microseconds *= 10;
  }
  seconds %= kTimesBeginAnew;
  return DeviceTime(std::chrono::microseconds(seconds * 1'000'000 + microseconds));
}

void MultipartReader::restart() {
  pictures_.restart();
  line_size_ = 0;
  time_.reset();
}

void MultipartReader::add_to_line(char c) {
  if (c == '\n') return end_line();
  if (line_size_ < line_.size()) line_[line_size_] = c;
  ++line_size_;
}

void MultipartReader::end_line() {
  const std::string_view line(line_.data(), std::min(line_size_, line_.size()));
  const bool whole = line_size_ <= line_.size();
  line_size_ = 0;
  if (line.starts_with("--")) time_.reset();  // A part begins, and tells its own time or none.
  if (whole && line.size() > kTimestamp.size() &&
      equal_ignoring_case(line.substr(0, kTimestamp.size()), kTimestamp))
    time_ = parse_timestamp(trimmed(line.substr(kTimestamp.size()), " \t\r"));
}

void MultipartReader::read_lines_of_broken() {
  line_size_ = 0;
  time_.reset();
  const auto kept = pictures_.picture();
  if (kept.size() == sensor::kMaxPayload) return;  // Its end was not kept.
  for (const char c : as_text(kept.last(std::min(kept.size(), kLinesBack)))) add_to_line(c);
}

std::optional<MultipartReader::Picture> MultipartReader::read(std::span<const std::byte>& bytes) {
  while (const auto newest = pictures_.next(bytes)) {
    if (!pictures_.is_open()) {
      if ((*newest & 0xFFFFFFU) == kPictureBegins)
        pictures_.begin(kFirstBytes);
      else
        add_to_line(static_cast<char>(*newest));
      continue;
    }
    if (pictures_.add(static_cast<std::byte>(*newest))) {
      line_size_ = 0;
      const auto time = time_;
      time_.reset();
      return Picture{pictures_.picture(), time};
    }
    if (!pictures_.is_open()) read_lines_of_broken();
  }
  return std::nullopt;
}

}  // namespace mien::headset
