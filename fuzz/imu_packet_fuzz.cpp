#include <algorithm>
#include <cstdlib>
#include <vector>

#include "mien/core/bytes.h"
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
