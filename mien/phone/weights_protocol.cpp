#include "mien/phone/weights_protocol.h"

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
  add_readings(packet->face, packet->device, {packet->sequence, packet->time}, inbox);
  if (packet->battery_percent != sensor::kBatteryUnknown)
    inbox.batteries.push_back({{packet->device, 0}, packet->battery_percent});
  return Verdict::taken;
}

}  // namespace mien::phone
