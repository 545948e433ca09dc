#include "mien/speech/sound_protocol.h"

#include "mien/speech/sound_block.h"

namespace mien::speech {

using sensor::Verdict;

bool SoundProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_block(datagram);
}

Verdict SoundProtocol::receive_with_payload(HostTime, sensor::Peer, std::span<const std::byte> datagram,
                                            std::span<const std::byte> payload, sensor::Inbox& inbox) {
  const auto header = parse_header(datagram);
  if (!header) return header.error().code == ErrorCode::unsupported ? Verdict::ignored : Verdict::malformed;
  const auto block = samples_of(payload);
  if (!block) return Verdict::malformed;
  inbox.readings.push_back(
      {.from = {header->device, 0}, .sample = sample_of(*header, *block), .payload = payload});
  return Verdict::taken;
}

bool MicrophoneProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_packet(datagram);
}

Verdict MicrophoneProtocol::receive(HostTime, sensor::Peer, std::span<const std::byte> datagram,
                                    sensor::Inbox& inbox) {
  const auto packet = parse_packet(datagram);
  // Of another version too: what is ignored is logged, and a voice must not be.
  if (!packet) return Verdict::malformed;
  const auto block = samples_of(packet->samples);
  if (!block) return Verdict::malformed;
  inbox.readings.push_back({.from = {packet->header.device, 0},
                            .sample = sample_of(packet->header, *block),
                            .payload = packet->samples});
  return Verdict::taken;
}

}  // namespace mien::speech
