#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "fuzz/with_checksum.h"
#include "mien/gaze/packet.h"

namespace {

void check(std::span<const std::byte> bytes) {
  const auto packet = mien::gaze::parse_packet(bytes);
  if (!packet) return;
  // What was accepted goes back to the same bytes, and through a sample.
  const auto again = mien::gaze::encode_packet(*packet);
  if (!again || !std::ranges::equal(*again, bytes)) std::abort();
  if (mien::gaze::eyes_of(mien::gaze::sample_of(packet->eyes)) != packet->eyes) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  with_checksum(data, size, check);
  return 0;
}
