#include <algorithm>
#include <cstdlib>
#include <span>
#include <vector>

#include "fuzz/with_checksum.h"
#include "mien/imu/packets/packet.h"

namespace {

void check(std::span<const std::byte> bytes) {
  const auto packet = mien::imu::parse_packet(bytes);
  if (!packet) return;
  // What was accepted goes back to the same bytes.
  const auto again = mien::imu::encode_packet(*packet);
  if (!again || !std::equal(again->begin(), again->end(), bytes.begin(), bytes.end())) std::abort();
  std::vector<mien::sensor::Sample> samples;
  mien::imu::append_samples(*packet, 3, samples);
  if (samples.size() != packet->count) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  with_checksum(data, size, check);
  return 0;
}
