#include "mien/core/excerpt.h"

#include "mien/core/utf8.h"

namespace mien {
namespace {

/// `letter`: well-formed UTF-8 of one letter.
bool is_shown(std::string_view letter) {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(letter[at]); };
  if (letter.size() == 1) return byte(0) >= 0x20 && byte(0) != 0x7F;
  if (letter.size() == 2) return byte(0) != 0xC2 || byte(1) >= 0xA0;  // U+0080 to U+009F are controls.
  if (letter.size() == 4) return true;
  const unsigned point = (byte(0) & 0x0FU) << 12U | (byte(1) & 0x3FU) << 6U | (byte(2) & 0x3FU);
  const bool invisible = (point >= 0x200B && point <= 0x200F) || (point >= 0x2028 && point <= 0x202E) ||
                         (point >= 0x2060 && point <= 0x206F) || point == 0xFEFF;
  return !invisible;
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
