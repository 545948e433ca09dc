#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/imu/packets/slimevr_protocol.h"

namespace {

/// One session: two peers, arrivals as the input says.
class Session {
 public:
  void receive(std::uint8_t wait_ms, mien::sensor::Peer peer, std::span<const std::byte> datagram) {
    now_ += std::chrono::milliseconds(wait_ms);
    inbox_.clear();
    const auto verdict = protocol_.receive(now_, peer, datagram, inbox_);
    if (verdict == mien::sensor::Verdict::malformed && !(inbox_.readings.empty() && inbox_.reply.empty()))
      std::abort();
    for (const auto& reading : inbox_.readings) {
      for (const float value : reading.sample.used())
        if (!std::isfinite(value)) std::abort();
      // Times rise, sensor by sensor; of two peers that say one number, whoever chooses between them hears
      // one.
      const auto [last, first] = newest_.try_emplace({peer, reading.from}, reading.sample.time);
      if (!first && reading.sample.time <= last->second) std::abort();
      last->second = reading.sample.time;
    }
    if (!inbox_.reply.empty() && !mien::imu::slimevr::parse_server_message(inbox_.reply)) std::abort();
    said_.clear();
    protocol_.heartbeats(now_, said_);
    for (const auto& outgoing : said_)
      if (!mien::imu::slimevr::parse_server_message(outgoing.datagram)) std::abort();
  }

 private:
  mien::imu::SlimeVrProtocol protocol_;
  mien::HostTime now_;
  mien::sensor::Inbox inbox_;
  std::vector<mien::sensor::Protocol::Outgoing> said_;
  std::map<std::pair<mien::sensor::Peer, mien::sensor::DeviceKey>, mien::DeviceTime> newest_;
};

/// What was read goes through the encoder and back unchanged, but for what the wire says in two ways.
void check_round_trip(std::span<const std::byte> datagram) {
  namespace slimevr = mien::imu::slimevr;
  (void)slimevr::parse_server_message(datagram);
  std::vector<slimevr::TrackerMessage> messages;
  const auto header = slimevr::parse_tracker_datagram(datagram, messages);
  if (!header) return;
  for (const slimevr::TrackerMessage& message : messages) {
    if (std::holds_alternative<slimevr::Unknown>(message)) continue;
    mien::ByteWriter writer;
    if (!encode_tracker_message(header->number, message, writer)) std::abort();
    if (!slimevr::is_tracker_datagram(writer.bytes())) std::abort();
    std::vector<slimevr::TrackerMessage> again;
    if (!slimevr::parse_tracker_datagram(writer.bytes(), again) || again.size() != 1 || again[0] != message)
      std::abort();
  }
}

}  // namespace

// Datagrams, each after a wait in ms, a peer and its length of two bytes. The first peer has shaken hands.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Session session;
  mien::ByteWriter handshake;
  if (!encode_tracker_message(0, mien::imu::slimevr::Handshake{.mac = 0x024D49454E00}, handshake))
    std::abort();
  session.receive(0, 0, handshake.bytes());
  mien::ByteReader reader(std::as_bytes(std::span(data, size)));
  while (reader.left() > 4) {
    const auto wait_ms = reader.little<std::uint8_t>();
    const mien::sensor::Peer peer = reader.little<std::uint8_t>() % 2U;
    const std::size_t length = std::min<std::size_t>(reader.little<std::uint16_t>(), reader.left());
    const auto datagram = reader.take(length);
    session.receive(wait_ms, peer, datagram);
    check_round_trip(datagram);
  }
  return 0;
}
