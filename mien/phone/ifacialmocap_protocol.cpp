#include "mien/phone/ifacialmocap_protocol.h"

#include <array>

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
    inbox.alive = {place->device, 0};
    return Verdict::taken;
  }
  std::array<sensor::Sample, kMostParts> samples;
  const std::size_t used = samples_of(frame->face, samples);
  for (sensor::Sample& sample : std::span(samples).first(used)) {
    sample.sequence = static_cast<std::uint32_t>(phone.frames);
    sample.time = time;
    sample.time_estimated = true;
    inbox.readings.push_back({.from = {place->device, 0}, .sample = sample});
  }
  return Verdict::taken;
}

}  // namespace mien::phone
