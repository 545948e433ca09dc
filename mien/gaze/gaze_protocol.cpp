#include "mien/gaze/gaze_protocol.h"

#include <algorithm>
#include <utility>

#include "mien/gaze/osc.h"
#include "mien/gaze/packet.h"

namespace mien::gaze {
namespace {

using sensor::Inbox;
using sensor::Verdict;

constexpr std::size_t kYaw = 0, kPitch = 1, kOpenness = 2, kPupil = 3;
bool tells_direction(const SaidOfEye& said) {
  return said.yaw_rad || said.pitch_rad;
}

bool tells_direction(const std::array<SaidOfEye, 2>& said) {
  return std::ranges::any_of(said, [](const SaidOfEye& eye) { return tells_direction(eye); });
}

bool tells_anything(const std::array<SaidOfEye, 2>& said) {
  return said != std::array<SaidOfEye, 2>();
}

}  // namespace

std::optional<float> GazeProtocol::Told::fresh(HostTime now) const {
  return at && now - *at <= kFresh ? std::optional(value) : std::nullopt;
}

bool GazeProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_packet(datagram) || is_osc(datagram);
}

Verdict GazeProtocol::receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                              Inbox& inbox) {
  return is_packet(datagram) ? take_packet(datagram, inbox) : take_osc(arrival, peer, datagram, inbox);
}

Verdict GazeProtocol::take_packet(std::span<const std::byte> bytes, Inbox& inbox) {
  const auto packet = parse_packet(bytes);
  if (!packet) return packet.error().code == ErrorCode::unsupported ? Verdict::ignored : Verdict::malformed;
  sensor::Sample sample = sample_of(packet->eyes);
  sample.sequence = packet->sequence;
  sample.time = packet->time;
  inbox.readings.push_back({.from = {packet->device, 0}, .sample = sample});
  if (packet->battery_percent != sensor::kBatteryUnknown)
    inbox.batteries.push_back({{packet->device, 0}, packet->battery_percent});
  return Verdict::taken;
}

Verdict GazeProtocol::take_osc(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                               Inbox& inbox) {
  const auto eyes = parse_osc_eyes(datagram);
  if (!eyes) return Verdict::malformed;
  if (std::ranges::none_of(eyes->said, tells_anything)) return Verdict::ignored;
  auto* const place = devices_.meet(peer, arrival);
  if (place == nullptr) return Verdict::ignored;
  OscDevice* const device = &place->state;
  inbox.alive = {place->device, 0};
  for (std::size_t d = 0; d < kDialectCount; ++d) {
    const bool preferred = std::ranges::any_of(std::span(device->dialects).first(d), [&](const auto& heard) {
      return heard && arrival - *heard <= kFresh;
    });
    if (preferred || !tells_anything(eyes->said[d])) continue;
    if (tells_direction(eyes->said[d])) device->dialects[d] = arrival;
    if (!completes_round(note(arrival, eyes->said[d], *device), *device)) continue;
    ++device->rounds;
    sensor::Sample sample = sample_of(eyes_at(arrival, *device));
    sample.sequence = static_cast<std::uint32_t>(device->rounds);
    sample.time = device->clock.add(arrival, device->rounds);
    sample.time_estimated = true;
    inbox.readings.push_back({.from = {place->device, 0}, .sample = sample});
    break;  // One sample an arrival.
  }
  return Verdict::taken;
}

unsigned GazeProtocol::note(HostTime arrival, const std::array<SaidOfEye, 2>& said, OscDevice& device) {
  unsigned directions = 0;
  for (std::size_t e = 0; e < said.size(); ++e) {
    const auto tell = [&](std::size_t what, const std::optional<float>& value) {
      if (!value) return false;
      device.told[e][what] = {*value, arrival};
      return true;
    };
    if (tell(kYaw, said[e].yaw_rad)) {
      directions |= 1U << (2 * e);
      device.lost[e][kYaw] = said[e].lost[kYaw];
    }
    if (tell(kPitch, said[e].pitch_rad)) {
      directions |= 2U << (2 * e);
      device.lost[e][kPitch] = said[e].lost[kPitch];
    }
    tell(kOpenness, said[e].openness);
    tell(kPupil, said[e].pupil_mm);
  }
  return directions;
}

bool GazeProtocol::completes_round(unsigned told, OscDevice& device) {
  if (told == 0) return false;
  if ((device.seen & told) != 0) {
    device.expected = device.seen;
    device.seen = 0;
    device.complete = false;
  }
  device.seen |= told;
  constexpr unsigned kAll = 15;
  const bool all =
      device.seen == kAll || (device.expected != 0 && (device.seen & device.expected) == device.expected);
  return all && !std::exchange(device.complete, true);
}

Eyes GazeProtocol::eyes_at(HostTime arrival, const OscDevice& device) {
  Eyes eyes;
  for (std::size_t e = 0; e < eyes.size(); ++e) {
    const auto& told = device.told[e];
    eyes[e].openness = told[kOpenness].fresh(arrival);
    eyes[e].pupil_mm = told[kPupil].fresh(arrival);
    const auto yaw = told[kYaw].fresh(arrival);
    const auto pitch = told[kPitch].fresh(arrival);
    if (!yaw || !pitch || device.lost[e][kYaw] || device.lost[e][kPitch]) continue;
    eyes[e].yaw_rad = *yaw;
    eyes[e].pitch_rad = *pitch;
    eyes[e].confidence = 1;
  }
  return eyes;
}

}  // namespace mien::gaze
