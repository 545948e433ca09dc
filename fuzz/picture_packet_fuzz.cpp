#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "fuzz/with_checksum.h"
#include "mien/headset/picture_packet.h"

namespace {

void check(std::span<const std::byte> bytes) {
  const auto packet = mien::headset::parse_picture_packet(bytes);
  if (!packet) return;
  // What was accepted goes back to the same bytes.
  mien::ByteWriter again;
  if (!mien::headset::write_picture_packet(*packet, again) || !std::ranges::equal(again.bytes(), bytes))
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  with_checksum(data, size, check);
  return 0;
}
