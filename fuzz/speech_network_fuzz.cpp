#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/speech/speech_network.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto file = mien::speech::parse_speech_network(std::as_bytes(std::span(data, size)), "fuzz");
  // What was accepted can be written, and is accepted again.
  if (file && !mien::speech::format_speech_network(*file)) std::abort();
  return 0;
}
