#include "mien/phone/live_link_protocol.h"

#include <algorithm>
#include <cmath>

namespace mien::phone {
using sensor::Verdict;

void LiveLinkProtocol::count(std::uint32_t frame, Phone& phone) {
  if (!phone.frame) {
    phone.frame = phone.sequence = frame;
    return;
  }
  const auto ahead = static_cast<std::int64_t>(frame) - static_cast<std::int64_t>(*phone.frame);
  if (ahead > 0) phone.steps[phone.next_step++ % kSteps] = static_cast<std::uint32_t>(ahead);
  std::uint32_t usual = 0;
  for (const std::uint32_t step : phone.steps)
    if (step > 0 && (usual == 0 || step < usual)) usual = step;
  if (usual > 0 && ahead != 0) {
    const auto frames = std::llround(static_cast<double>(ahead) / usual);
    phone.sequence += static_cast<std::uint32_t>(frames != 0 ? frames : (ahead > 0 ? 1 : -1));
  }
  phone.frame = frame;
}

Verdict LiveLinkProtocol::receive(HostTime arrival, sensor::Peer, std::span<const std::byte> datagram,
                                  sensor::Inbox& inbox) {
  const auto packet = parse_live_link(datagram);
  if (!packet) return packet.error().code == ErrorCode::unsupported ? Verdict::ignored : Verdict::malformed;
  auto* const place = phones_.meet(packet->device_id, arrival);
  if (place == nullptr) return Verdict::ignored;
  Phone& phone = place->state;
  count(packet->frame, phone);
  if (!packet->values) {
    inbox.alive = {place->device, 0};
    return Verdict::taken;
  }
  std::array<sensor::Sample, kMostParts> samples;
  const std::size_t used = samples_of(told_face(*packet->values), samples);
  for (sensor::Sample& sample : std::span(samples).first(used)) {
    sample.sequence = phone.sequence;
    sample.time = packet->time();
    inbox.readings.push_back({.from = {place->device, 0}, .sample = sample});
  }
  return Verdict::taken;
}

}  // namespace mien::phone
