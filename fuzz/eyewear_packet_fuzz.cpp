#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "mien/core/bytes.h"
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
  const auto bytes = std::as_bytes(std::span(data, size));
  check(bytes);
  if (size < 4) return 0;
  // Once more with the checksum put right, or hardly any input would get past it.
  mien::ByteWriter writer;
  writer.append(bytes.first(size - 4));
  writer.little(mien::crc32(bytes.first(size - 4)));
  check(writer.bytes());
  return 0;
}
