#include "mien/core/toml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>

#include "mien/core/excerpt.h"
#include "mien/core/utf8.h"

namespace mien {
namespace {

/// A letter of UTF-8 beyond ASCII, as a string in double quotes may spell it.
std::string escaped(std::string_view letter) {
  const auto point = static_cast<std::uint32_t>(code_point(letter));
  return point > 0xFFFF ? fmt::format("\\U{:08X}", point) : fmt::format("\\u{:04X}", point);
}

/// The text without a byte beyond ASCII: question marks for them in comments, escapes in strings in double
/// quotes; an error with the line where one stands elsewhere. The library's search for exotic blanks runs off
/// its own table on them, so it gets to see none.
Result<std::string> plain_text(std::string_view toml_text, const std::string& where) {
  std::string out(toml_text);
  std::size_t line_number = 1;
  std::size_t i = 0;
  if (toml_text.starts_with("\xEF\xBB\xBF")) {
    out.replace(0, 3, "   ");  // A byte order mark.
    i = 3;
  }
  bool comment = false;
  std::string end;               // Of the string that we are in.
  bool after_backslash = false;  // Of such a string, that escapes nothing yet.
  while (i < out.size()) {
    const char c = out[i];
    if (static_cast<unsigned char>(c) >= 0x80) {
      const std::size_t letter = utf8_letter(std::string_view(out).substr(i));
      if (!comment && end.starts_with('"') && letter > 0 && !after_backslash) {
        const std::string escape = escaped(std::string_view(out).substr(i, letter));
        out.replace(i, letter, escape);
        i += escape.size();
        continue;
      }
      if (!comment)
        return fail(ErrorCode::malformed,
                    "a letter beyond ASCII outside of a comment or a text in double quotes",
                    fmt::format("{}, line {}", where, line_number),
                    letter > 0 ? "use plain letters, or double quotes" : "save the file as UTF-8");
      out[i] = '?';
    }
    after_backslash = false;
    if (c == '\n') {
      ++line_number;
      comment = false;
      if (end.size() == 1) end.clear();
    }
    std::size_t step = 1;
    if (!comment && !end.empty()) {
      if (out.compare(i, end.size(), end) == 0) {
        step = end.size();
        end.clear();
      } else if (c == '\\' && end[0] == '"' && i + 1 < out.size() &&
                 static_cast<unsigned char>(out[i + 1]) < 0x80 && out[i + 1] != '\n') {
        step = 2;
      } else {
        after_backslash = c == '\\' && end[0] == '"';
      }
    } else if (!comment && (c == '"' || c == '\'')) {
      end = out.compare(i, 3, std::string(3, c)) == 0 ? std::string(3, c) : std::string(1, c);
      step = end.size();
    } else if (c == '#') {
      comment = true;
    }
    i += step;
  }
  return out;
}

/// What the library says of an error, on one line. What it repeats of the text stands between its first
/// single quote and the last, which is missing where that is long.
std::string one_line(std::string_view description) {
  const std::size_t first = description.find('\'');
  if (first == std::string_view::npos) return without_controls(description);
  const std::size_t last = description.find('\'', first + 1) == std::string_view::npos
                               ? description.size()
                               : description.rfind('\'');
  const std::string_view rest = last == description.size() ? "'" : description.substr(last);
  return without_controls(description.substr(0, first + 1)) +
         excerpt(description.substr(first + 1, last - first - 1)) + without_controls(rest);
}

}  // namespace

Result<toml::table> parse_toml(std::string_view text, const std::string& where) {
  MIEN_TRY_ASSIGN(const std::string plain, plain_text(text, where));
  toml::parse_result parsed = toml::parse(plain);
  if (!parsed)
    return fail(ErrorCode::malformed, one_line(parsed.error().description()),
                fmt::format("{}, line {}", where, parsed.error().source().begin.line));
  return std::move(parsed).table();
}

std::string place(const std::string& where, const toml::node& node) {
  const auto line = node.source().begin.line;
  return line == 0 ? where : fmt::format("{}, line {}", where, line);
}

Result<void> only_keys(const toml::table& table, std::initializer_list<std::string_view> known,
                       const std::string& where) {
  for (const auto& [key, value] : table)
    if (std::ranges::find(known, key.str()) == known.end())
      return fail(ErrorCode::malformed, fmt::format("unknown key '{}'", excerpt(key.str())),
                  place(where, value), fmt::format("known keys are: {}", fmt::join(known, ", ")));
  return {};
}

}  // namespace mien
