#include "mien/phone/ifacialmocap_protocol.h"

namespace mien::phone {

using sensor::Verdict;

Verdict IFacialMocapProtocol::receive(HostTime arrival, sensor::Peer peer,
                                      std::span<const std::byte> datagram, sensor::Inbox& inbox) {
  const auto frame = parse_ifacialmocap(datagram);
  if (!frame) return Verdict::malformed;
  auto* const place = phones_.meet(peer, arrival);
  if (place == nullptr) return Verdict::ignored;
  Phone& phone = place->state;
  const DeviceTime time = phone.clock.add(arrival, ++phone.frames);
  if (!frame->tracked) {
    inbox.alive = inbox.no_face = {place->device, 0};
    return Verdict::taken;
  }
  add_readings(frame->face, place->device, {static_cast<std::uint32_t>(phone.frames), time, true}, inbox);
  return Verdict::taken;
}

}  // namespace mien::phone
