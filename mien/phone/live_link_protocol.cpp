#include "mien/phone/live_link_protocol.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace mien::phone {
using sensor::Verdict;

double LiveLinkProtocol::usual_step(const Phone& phone) {
  std::array<std::uint32_t, kSteps> steps = phone.steps;
  const auto known = std::span(steps).first(std::min(phone.next_step, kSteps));
  if (known.empty()) return 0;
  // A few early frames do not make it shorter, nor lost ones longer.
  std::ranges::sort(known);
  const std::uint32_t least = known[known.size() / 4];
  if (least == 1) return 1;
  double sum = 0, count = 0;
  for (const std::uint32_t step : known)
    if (step == least || step == least + 1) {
      sum += step;
      ++count;
    }
  return sum / count;
}

void LiveLinkProtocol::count(std::uint32_t frame, bool face, Phone& phone) {
  if (!phone.frame) {
    phone.frame = phone.sequence = frame;
    return;
  }
  const auto ahead = static_cast<std::int64_t>(frame) - static_cast<std::int64_t>(*phone.frame);
  if (ahead > 0) phone.steps[phone.next_step++ % kSteps] = static_cast<std::uint32_t>(ahead);
  if (const double usual = usual_step(phone); usual > 0 && ahead != 0) {
    auto frames = std::llround(static_cast<double>(ahead) / usual);
    if (frames == 0) frames = ahead > 0 ? 1 : -1;
    if (!face && frames > 0) --frames;
    phone.sequence += static_cast<std::uint32_t>(frames);
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
  if (packet->timed) count(packet->frame, packet->values.has_value(), phone);
  if (!packet->values) {
    inbox.alive = inbox.no_face = {place->device, 0};
    return Verdict::taken;
  }
  add_readings(told_face(*packet->values), place->device, {phone.sequence, packet->time()}, inbox);
  return Verdict::taken;
}

}  // namespace mien::phone
