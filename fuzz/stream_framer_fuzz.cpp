#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/sensor/stream_framer.h"

// A frame is part of the stream, ends where it was told, and is never longer than it may be; behind a zero
// that follows it nothing of what was before shows.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using mien::sensor::StreamFramer;
  const auto stream = std::as_bytes(std::span(data, size));
  StreamFramer framer;
  for (std::size_t i = 0; i < size; ++i) {
    const auto frame = framer.add(stream[i]);
    if (frame.empty()) continue;
    if (frame.size() > StreamFramer::kMaxFrame || frame.size() > i) std::abort();
    if (stream[i] != std::byte{0} && stream[i] != std::byte{'\n'}) std::abort();
    if (std::ranges::find(frame, std::byte{0}) != frame.end()) std::abort();
    const auto before = stream.first(i);
    const bool whole = std::ranges::equal(frame, before.last(frame.size()));
    const bool returned =
        frame.size() < i && std::ranges::equal(frame, before.first(i - 1).last(frame.size()));
    if (!whole && !returned) std::abort();
  }
  static_cast<void>(framer.add(std::byte{0}));
  StreamFramer fresh;
  for (const std::byte b : stream) {
    const auto one = framer.add(b);
    const auto other = fresh.add(b);
    if (!std::ranges::equal(one, other)) std::abort();
  }
  return 0;
}
