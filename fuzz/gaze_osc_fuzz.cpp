#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mien/core/bytes.h"
#include "mien/gaze/gaze_protocol.h"
#include "mien/gaze/osc_eyes.h"

namespace {

using mien::sensor::Verdict;

/// What is accepted is in its range, and a protocol that hears only what a log would have kept says the same.
struct Hosts {
  mien::gaze::GazeProtocol live, replay;

  void hear(mien::HostTime arrival, mien::sensor::Peer peer, std::span<const std::byte> datagram) {
    const auto eyes = mien::gaze::parse_osc_eyes(datagram);
    if (eyes)
      for (const auto& dialect : eyes->said)
        for (const mien::gaze::SaidOfEye& eye : dialect)
          if (!mien::gaze::is_sound(
                  {eye.yaw_rad.value_or(0), eye.pitch_rad.value_or(0), 0, eye.openness, eye.pupil_mm}))
            std::abort();
    if (!live.recognises(datagram)) return;
    mien::sensor::Inbox inbox, again;
    const Verdict verdict = live.receive(arrival, peer, datagram, inbox);
    if (inbox.readings.size() > 1 || (verdict != Verdict::taken && !inbox.readings.empty())) std::abort();
    if (verdict == Verdict::malformed || verdict == Verdict::refused) return;
    if (replay.receive(arrival, peer, datagram, again) != verdict) std::abort();
    if (again.readings.size() != inbox.readings.size()) std::abort();
    for (std::size_t i = 0; i < inbox.readings.size(); ++i) {
      const auto& a = inbox.readings[i].sample;
      const auto& b = again.readings[i].sample;
      if (a.time != b.time || a.sequence != b.sequence || a.values != b.values) std::abort();
      if (!mien::gaze::eyes_of(a)) std::abort();
    }
  }
};

}  // namespace

// Datagrams, each after two bytes: its length, of which the high bit names the sender, and milliseconds since
// the one before; and the whole as one datagram.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Hosts hosts;
  const auto bytes = std::as_bytes(std::span(data, size));
  hosts.hear(mien::HostTime(), 0, bytes);
  mien::ByteReader reader(bytes);
  mien::HostTime now;
  while (reader.left() > 2) {
    const auto first = reader.little<std::uint8_t>();
    now += std::chrono::milliseconds(reader.little<std::uint8_t>());
    hosts.hear(now, first >> 7U, reader.take(std::min<std::size_t>(first & 127U, reader.left())));
  }
  return 0;
}
