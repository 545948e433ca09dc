#include "app/one_line.h"

namespace mien::app {

std::string one_line(std::string_view text, std::size_t max_bytes) {
  std::string line;
  for (const char letter : text.substr(0, max_bytes)) {
    const auto byte = static_cast<unsigned char>(letter);
    // U+0080 to U+009F, which some terminals obey, are C2 80 to C2 9F.
    const bool second_half = !line.empty() && line.back() == '\xC2' && byte >= 0x80 && byte < 0xA0;
    if (second_half) line.back() = ' ';
    line += second_half || byte < 0x20 || byte == 0x7F ? ' ' : letter;
  }
  return text.size() > max_bytes ? line + "..." : line;
}

}  // namespace mien::app
