#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/speech/sound_message.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto message = mien::speech::parse_message(bytes);
  if (!message) return 0;
  if (message->samples.empty() || message->samples.size() > 19'200) std::abort();
  // What was accepted goes back to the same bytes.
  if (!std::ranges::equal(mien::speech::encode_message(*message), bytes)) std::abort();
  return 0;
}
