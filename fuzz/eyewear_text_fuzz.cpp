#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "mien/eyewear/text_line.h"

// What was accepted and written anew says the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace mien::eyewear;
  const auto line = parse_text_line(std::as_bytes(std::span(data, size)));
  if (!line) return 0;
  std::string text;
  if (const auto* values = std::get_if<TextValues>(&*line)) {
    if (values->count < 1 || values->count > kMaxTextValues) std::abort();
    for (std::size_t i = 0; i < values->count; ++i) text += std::to_string(values->values[i]) + ",";
    const auto again = parse_text_line(std::as_bytes(std::span(text)));
    const auto* same = again ? std::get_if<TextValues>(&*again) : nullptr;
    if (same == nullptr || same->count != values->count || same->values != values->values) std::abort();
  } else if (const auto* header = std::get_if<TextHeader>(&*line)) {
    text = header->pairs ? "# mien on off" : "# mien";
    if (header->adc_bits != 0) text += " bits " + std::to_string(header->adc_bits);
    const auto again = parse_text_line(std::as_bytes(std::span(text)));
    const auto* same = again ? std::get_if<TextHeader>(&*again) : nullptr;
    if (same == nullptr || *same != *header) std::abort();
  }
  return 0;
}
