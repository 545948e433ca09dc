#include "mien/core/excerpt.h"

#include "mien/core/utf8.h"

namespace mien {
namespace {

/// `letter`: well-formed UTF-8 of one letter.
bool is_shown(std::string_view letter) {
  const char32_t point = code_point(letter);
  const bool control = point < 0x20 || (point >= 0x7F && point <= 0x9F);
  const bool invisible = (point >= 0x200B && point <= 0x200F) || (point >= 0x2028 && point <= 0x202E) ||
                         (point >= 0x2060 && point <= 0x206F) || point == 0xFEFF;
  return !control && !invisible;
}

}  // namespace

std::string excerpt(std::string_view text, std::size_t letters) {
  std::string out;
  for (; !text.empty(); --letters) {
    if (letters == 0) return out + "...";
    const std::size_t length = utf8_letter(text);
    const std::string_view letter = text.substr(0, length);
    if (letter == "\n" || letter == "\r" || letter == "\t")
      out += ' ';
    else if (length > 0 && is_shown(letter))
      out += letter;
    else
      out += '?';
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

std::string without_controls(std::string_view text) {
  return excerpt(text, text.size());
}

}  // namespace mien
