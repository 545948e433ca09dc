#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "mien/headset/picture_packet.h"
#include "mien/headset/picture_streams.h"

namespace {

struct Outcome {
  std::vector<std::vector<std::byte>> payloads;
  bool ended = false;
  bool operator==(const Outcome&) const = default;
};

Outcome outcome(std::span<const std::byte> bytes, std::size_t piece) {
  static mien::headset::MjpegStream stream({.device = 7});
  stream.restart();
  Outcome out;
  while (!bytes.empty()) {
    const auto some = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(some.size());
    const auto read = stream.read(some, [&](auto datagram, auto payload) {
      const auto packet = mien::headset::parse_picture_packet(datagram);
      if (!packet || packet->first != out.payloads.empty()) std::abort();
      out.payloads.emplace_back(payload.begin(), payload.end());
    });
    if (read) continue;
    if (read.error().what.empty()) std::abort();
    out.ended = true;
    break;
  }
  return out;
}

}  // namespace

// A camera's whole answer, its head, chunks and parts: however it is cut, the same comes out.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const Outcome whole = outcome(bytes, size);
  if (size > 0 && outcome(bytes, 1 + data[size - 1] % 7) != whole) std::abort();
  return 0;
}
