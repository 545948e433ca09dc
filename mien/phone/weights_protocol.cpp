#include "mien/phone/weights_protocol.h"

#include <array>

#include "mien/phone/packet.h"

namespace mien::phone {

using sensor::Verdict;

bool WeightsProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_packet(datagram);
}

Verdict WeightsProtocol::receive(HostTime, sensor::Peer, std::span<const std::byte> datagram,
                                 sensor::Inbox& inbox) {
  const auto packet = parse_packet(datagram);
  if (!packet) return packet.error().code == ErrorCode::unsupported ? Verdict::ignored : Verdict::malformed;
  std::array<sensor::Sample, kMostParts> samples;
  const std::size_t used = samples_of(packet->face, samples);
  for (sensor::Sample& sample : std::span(samples).first(used)) {
    sample.sequence = packet->sequence;
    sample.time = packet->time;
    inbox.readings.push_back({.from = {packet->device, 0}, .sample = sample});
  }
  if (used == 0) inbox.alive = {packet->device, 0};
  if (packet->battery_percent != sensor::kBatteryUnknown)
    inbox.batteries.push_back({{packet->device, 0}, packet->battery_percent});
  return Verdict::taken;
}

}  // namespace mien::phone
