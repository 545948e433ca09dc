#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "mien/core/cobs.h"

// A frame that is accepted decodes to data that comes back; and any data goes there and back.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  std::vector<std::byte> room(size);
  const auto held = mien::cobs_decode(bytes, room);
  for (const auto& whole : {held ? *held : std::span<const std::byte>(), bytes}) {
    std::vector<std::byte> frame;
    mien::cobs_encode(whole, frame);
    if (frame.size() > mien::cobs_max_size(whole.size()) || std::ranges::count(frame, std::byte{0}) != 0)
      std::abort();
    std::vector<std::byte> again(frame.size());
    const auto back = mien::cobs_decode(frame, again);
    if (!back || !std::ranges::equal(*back, whole)) std::abort();
  }
  return 0;
}
