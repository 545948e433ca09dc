#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/live/video_message.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto message = mien::live::parse_video_message(bytes);
  if (!message) return 0;
  if (!mien::live::is_video_message(bytes) || message->data.empty() ||
      message->data.size() > mien::live::kMaxVideoChunk)
    std::abort();
  // What was accepted goes back to the same bytes.
  if (!std::ranges::equal(mien::live::encode_video_message(*message), bytes)) std::abort();
  return 0;
}
