#include <array>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "fuzz/with_checksum.h"
#include "mien/phone/inner_face.h"
#include "mien/phone/packet.h"

namespace {

using namespace mien;

void check(std::span<const std::byte> bytes) {
  const auto packet = phone::parse_packet(bytes);
  if (!packet) return;
  // What was accepted is accepted again, and goes through samples.
  const auto again = phone::encode_packet(*packet);
  if (!again || again->size() > phone::kMostPacketBytes) std::abort();
  const auto back = phone::parse_packet(*again);
  if (!back || *back != *packet) std::abort();
  std::array<sensor::Sample, phone::kMostParts> samples;
  const std::size_t used = phone::samples_of(packet->face, samples);
  phone::ToldFace face;
  for (const sensor::Sample& sample : std::span(samples).first(used))
    if (!phone::add_sample(sample, face)) std::abort();
  if (face.weights != packet->face.weights || face.confidence != packet->face.confidence ||
      face.head != packet->face.head)
    std::abort();
  for (const float weight : phone::inner_face(face).weights)
    if (!(weight >= 0 && weight <= 1)) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  with_checksum(data, size, check);
  return 0;
}
