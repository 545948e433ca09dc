#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>

#include "mien/headset/etvr_frames.h"

// A picture stands in the stream behind a header with its length, and is the same when the stream comes byte
// by byte.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using mien::headset::EtvrFrames;
  static EtvrFrames frames;  // Of 256 KiB each; a restart leaves nothing of the run before.
  static EtvrFrames others;
  frames.restart();
  others.restart();
  const auto bytes = std::as_bytes(std::span(data, size));
  std::size_t other_at = 0;
  for (auto left = bytes; const auto picture = frames.read(left);) {
    const std::size_t end = size - left.size();
    if (end < picture->size() + 6) std::abort();
    const auto frame = bytes.subspan(end - picture->size() - 6, picture->size() + 6);
    if (!std::ranges::equal(frame.subspan(6), *picture)) std::abort();
    if (frame[0] != std::byte{0xFF} || frame[1] != std::byte{0xA0} || frame[3] != std::byte{0xA1})
      std::abort();
    if ((std::to_integer<std::size_t>(frame[4]) | std::to_integer<std::size_t>(frame[5]) << 8U) !=
        picture->size())
      std::abort();
    std::optional<std::span<const std::byte>> other;
    for (; other_at < end; ++other_at) {
      if (other) std::abort();
      auto one = bytes.subspan(other_at, 1);
      other = others.read(one);
    }
    if (!other || !std::ranges::equal(*other, *picture)) std::abort();
  }
  return 0;
}
