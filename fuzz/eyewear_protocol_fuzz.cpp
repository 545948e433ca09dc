#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/cobs.h"
#include "mien/eyewear/eyewear_protocol.h"

namespace {

using mien::sensor::Verdict;

/// A protocol, and one that hears only what a log would have kept.
struct Hosts {
  mien::eyewear::EyewearProtocol live = make();
  mien::eyewear::EyewearProtocol replay = make();

  static mien::eyewear::EyewearProtocol make() {
    auto made = mien::eyewear::EyewearProtocol::create();
    if (!made) std::abort();
    return std::move(*made);
  }

  void hear(mien::HostTime arrival, mien::sensor::Peer peer, std::span<const std::byte> datagram) {
    if (!live.recognises(datagram)) return;
    mien::sensor::Inbox inbox;
    const Verdict verdict = live.receive(arrival, peer, datagram, inbox);
    const bool empty = inbox.readings.empty() && inbox.batteries.empty() && !inbox.alive;
    if (verdict != Verdict::taken && !empty) std::abort();
    if (!inbox.reply.empty() || !inbox.announcements.empty() || !inbox.pulses.empty()) std::abort();
    if (inbox.readings.size() > mien::eyewear::kMaxChannels) std::abort();
    for (const auto& reading : inbox.readings)
      for (const float value : reading.sample.used())
        if (!(value >= 0 && value <= 1)) std::abort();
    if (verdict == Verdict::malformed || verdict == Verdict::refused) return;
    mien::sensor::Inbox again;
    if (replay.receive(arrival, peer, datagram, again) != verdict) std::abort();
    const auto alike = [](const mien::sensor::Reading& a, const mien::sensor::Reading& b) {
      return a.from == b.from && a.sample.time == b.sample.time && a.sample.sequence == b.sample.sequence &&
             a.sample.values == b.sample.values;
    };
    if (!std::ranges::equal(inbox.readings, again.readings, alike)) std::abort();
  }
};

}  // namespace

// Frames, each after a byte whose low seven bits are its length and whose high bit names its sender, and a
// byte of milliseconds since the one before; as they come, and the bytes as a packet with its checksum put
// right.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Hosts hosts;
  mien::ByteReader reader(std::as_bytes(std::span(data, size)));
  mien::HostTime now;
  while (reader.left() > 2) {
    const auto first = reader.little<std::uint8_t>();
    now += std::chrono::milliseconds(reader.little<std::uint8_t>());
    const mien::sensor::Peer peer = first >> 7U;
    const auto bytes = reader.take(std::min<std::size_t>(first & 127U, reader.left()));
    hosts.hear(now, peer, bytes);
    if (bytes.size() < 4) continue;
    mien::ByteWriter right;
    right.append(bytes.first(bytes.size() - 4));
    right.little(mien::crc32(bytes.first(bytes.size() - 4)));
    hosts.hear(now, peer, right.bytes());
    std::vector<std::byte> frame;
    mien::cobs_encode(right.bytes(), frame);
    hosts.hear(now, peer, frame);
  }
  return 0;
}
