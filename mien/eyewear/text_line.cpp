#include "mien/eyewear/text_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>

namespace mien::eyewear {
namespace {

constexpr std::int32_t kMostSteps = (1 << kMaxAdcBits) - 1;
constexpr std::string_view kBlanks = " \t";
const char* const kTextLine = "text line";

bool is_blank(char c) {
  return kBlanks.find(c) != std::string_view::npos;
}

void skip_blanks(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
}

/// The next word, up to a blank; blanks before it are skipped. Empty at the end.
std::string_view take_word(std::string_view& text) {
  skip_blanks(text);
  const std::string_view word = text.substr(0, std::min(text.find_first_of(kBlanks), text.size()));
  text.remove_prefix(word.size());
  return word;
}

/// Takes a number off the front.
Result<std::int32_t> take_number(std::string_view& text) {
  std::int32_t value = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (wrong == std::errc::result_out_of_range || value > kMostSteps || value < -kMostSteps)
    return fail(ErrorCode::out_of_range, "a value beyond 16 bits", kTextLine);
  if (wrong != std::errc{}) return fail(ErrorCode::malformed, "a value is missing or no integer", kTextLine);
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return value;
}

/// What follows "#".
Result<TextLine> parse_header(std::string_view text) {
  if (take_word(text) != "mien") return TextComment{};
  TextHeader header;
  while (true) {
    const std::string_view word = take_word(text);
    if (word.empty()) return header;
    if (word == "on" && take_word(text) == "off") {
      header.pairs = true;
    } else if (word == "bits") {
      std::string_view digits = take_word(text);
      MIEN_TRY_ASSIGN(const std::int32_t bits, take_number(digits));
      if (!digits.empty()) return fail(ErrorCode::malformed, "bits that are no number", kTextLine);
      if (bits < kMinAdcBits || bits > kMaxAdcBits)
        return fail(ErrorCode::out_of_range,
                    fmt::format("a converter of {} bits, not {} to {}", bits, kMinAdcBits, kMaxAdcBits),
                    kTextLine);
      header.adc_bits = static_cast<std::uint8_t>(bits);
    } else {
      return fail(ErrorCode::malformed, "a header with a word that is unknown", kTextLine,
                  "write it as \"# mien on off bits 12\"");
    }
  }
}

Result<TextLine> parse_values(std::string_view text) {
  TextValues line;
  while (true) {
    skip_blanks(text);
    if (text.empty() && line.count > 0) return line;  // A separator after the last value.
    MIEN_TRY_ASSIGN(const std::int32_t value, take_number(text));
    if (line.count == line.values.size())
      return fail(ErrorCode::out_of_range, fmt::format("more than {} values", kMaxTextValues), kTextLine);
    line.values[line.count++] = value;
    if (text.empty()) return line;
    const bool blank = is_blank(text.front());
    skip_blanks(text);
    if (text.empty()) return line;
    if (text.front() == ',' || text.front() == ';')
      text.remove_prefix(1);
    else if (!blank)
      return fail(ErrorCode::malformed, "a value is missing or no integer", kTextLine);
  }
}

}  // namespace

bool is_text_line(std::span<const std::byte> bytes) {
  return !bytes.empty() && std::ranges::all_of(bytes, [](std::byte b) {
    return (b >= std::byte{0x20} && b <= std::byte{0x7E}) || b == std::byte{'\t'} || b == std::byte{'\r'} ||
           b == std::byte{'\n'};
  });
}

Result<TextLine> parse_text_line(std::span<const std::byte> line) {
  std::string_view text(reinterpret_cast<const char*>(line.data()), line.size());
  if (text.ends_with('\n')) text.remove_suffix(1);
  if (text.ends_with('\r')) text.remove_suffix(1);
  skip_blanks(text);
  if (!text.starts_with('#')) return parse_values(text);
  text.remove_prefix(1);
  return parse_header(text);
}

}  // namespace mien::eyewear
