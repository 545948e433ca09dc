#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "fuzz/with_checksum.h"
#include "mien/eyewear/packet.h"

namespace {

void check(std::span<const std::byte> bytes) {
  const auto packet = mien::eyewear::parse_packet(bytes);
  if (!packet) return;
  // What was accepted goes back to the same bytes, ...
  const auto again = mien::eyewear::encode_packet(*packet);
  if (!again || !std::ranges::equal(*again, bytes)) std::abort();
  // ... by way of samples too.
  std::vector<mien::sensor::Sample> scan;
  for (std::size_t c = 0; c < packet->channels; ++c) scan.push_back(sample_of(*packet, c, 0));
  const auto made = mien::eyewear::make_packet(scan, packet->adc_bits);
  if (!made || made->light != packet->light) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  with_checksum(data, size, check);
  return 0;
}
