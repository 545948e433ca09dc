#include "mien/eyewear/eyewear_protocol.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <tuple>

#include "mien/core/cobs.h"

namespace mien::eyewear {
namespace {

using sensor::Inbox;
using sensor::Verdict;

/// Size of a packet of kMaxChannels; longer COBS frames are not decoded.
constexpr std::size_t kMaxPacketBytes = 36 + 4 * kMaxChannels;
/// Successive lines that must agree on their number of values: two damaged ones may, eight will not.
constexpr int kAgreed = 8;
/// After this time without a line of the accepted number another is considered: a new sketch was uploaded.
constexpr Duration kDoubt = std::chrono::milliseconds(500);
/// A candidate that was silent for so long is forgotten before others.
constexpr Duration kPause = std::chrono::seconds(1);
/// A device without an accepted line for so long gives its place to another where all are taken.
constexpr Duration kForget = std::chrono::seconds(10);
/// Sketches print 10 to 1000 lines a second.
const sensor::EstimatedClockSettings kTextClock = {.min_period = std::chrono::milliseconds(1),
                                                   .max_period = std::chrono::milliseconds(100)};

/// Whether it begins like a COBS frame of our packet: the first zero of a packet is behind its type, so the
/// first code byte hides nothing before it.
bool is_frame(std::span<const std::byte> bytes) {
  return !bytes.empty() && is_packet(bytes.subspan(1));
}

}  // namespace

Result<EyewearProtocol> EyewearProtocol::create(EyewearProtocolSettings settings) {
  if (settings.text_bits < kMinAdcBits || settings.text_bits > kMaxAdcBits)
    return fail(ErrorCode::bad_usage, "a converter with fewer than 8 or more than 16 bits",
                "eyewear protocol");
  return EyewearProtocol(settings);
}

EyewearProtocol::EyewearProtocol(EyewearProtocolSettings settings) : settings_(settings) {
  candidates_.reserve(kMaxTextCandidates);
  devices_.reserve(kMaxTextDevices);
  former_.reserve(kMaxTextDevices);
}

bool EyewearProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_packet(datagram) || is_frame(datagram) || is_text_line(datagram);
}

Verdict EyewearProtocol::receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                                 Inbox& inbox) {
  if (is_packet(datagram)) return take_packet(datagram, inbox);
  if (!is_frame(datagram)) return take_line(arrival, peer, datagram, inbox);
  std::array<std::byte, kMaxPacketBytes> room;
  const auto packet = cobs_decode(datagram, room);
  return packet ? take_packet(*packet, inbox) : Verdict::malformed;
}

Verdict EyewearProtocol::take_packet(std::span<const std::byte> bytes, Inbox& inbox) {
  const auto packet = parse_packet(bytes);
  if (!packet) return packet.error().code == ErrorCode::unsupported ? Verdict::ignored : Verdict::malformed;
  for (std::uint8_t c = 0; c < packet->channels; ++c) {
    inbox.readings.push_back({.from = {packet->device, c},
                              .sample = sample_of(*packet, c, 0),
                              .saturated = is_saturated(*packet, c)});
    if (packet->battery_percent != kBatteryUnknown)
      inbox.batteries.push_back({{packet->device, c}, packet->battery_percent});
  }
  return Verdict::taken;
}

bool EyewearProtocol::Run::add(std::size_t its_values) {
  lines = values == its_values ? lines + 1 : 1;
  values = its_values;
  return lines >= kAgreed;
}

EyewearProtocol::TextCandidate& EyewearProtocol::meet(sensor::Peer peer, HostTime arrival) {
  const auto known = std::ranges::find(candidates_, peer, &TextCandidate::peer);
  if (known != candidates_.end()) return *known;
  if (candidates_.size() < kMaxTextCandidates) return candidates_.emplace_back(TextCandidate{.peer = peer});
  const auto place = std::ranges::min_element(candidates_, {}, [&](const TextCandidate& one) {
    return std::tuple(arrival - one.received <= kPause, one.run.lines, one.received);
  });
  *place = {.peer = peer};
  return *place;
}

EyewearProtocol::TextDevice* EyewearProtocol::accept(HostTime arrival, const TextCandidate& candidate) {
  TextDevice* place = nullptr;
  if (devices_.size() < kMaxTextDevices) {
    place = &devices_.emplace_back();
  } else {
    const auto silent = std::ranges::min_element(devices_, {}, &TextDevice::accepted);
    if (arrival - silent->accepted <= kForget) return nullptr;
    place = &*silent;
    if (former_.size() == kMaxTextDevices) former_.erase(former_.begin());
    former_.push_back({place->peer, place->id});
  }
  // An id that a rig binds is never another's.
  const auto own = std::ranges::find(former_, candidate.peer, &Id::peer);
  const std::uint64_t id = own != former_.end() ? own->device : kTextDevice + text_devices_++;
  if (own != former_.end()) former_.erase(own);
  *place = {.peer = candidate.peer,
            .id = id,
            .header = candidate.header,
            .columns = candidate.run.values,
            .clock = sensor::EstimatedClock(kTextClock)};
  return place;
}

std::int32_t EyewearProtocol::full_scale(const TextHeader& header) const {
  return (1 << (header.adc_bits != 0 ? header.adc_bits : settings_.text_bits)) - 1;
}

bool EyewearProtocol::is_sound(const TextValues& line, const TextHeader& header) const {
  const std::size_t per_channel = header.pairs ? 2 : 1;
  const std::int32_t most = full_scale(header);
  return line.count % per_channel == 0 && line.count <= per_channel * kMaxChannels &&
         std::ranges::all_of(std::span(line.values).first(line.count), [&](std::int32_t value) {
           return std::abs(value) <= most && (value >= 0 || per_channel == 1);
         });
}

Verdict EyewearProtocol::take_line(HostTime arrival, sensor::Peer peer, std::span<const std::byte> bytes,
                                   Inbox& inbox) {
  const auto line = parse_text_line(bytes);
  if (!line) return Verdict::malformed;
  if (std::holds_alternative<TextComment>(*line)) return Verdict::ignored;
  const auto device = std::ranges::find(devices_, peer, &TextDevice::peer);
  if (device == devices_.end()) return take_line_of_candidate(arrival, peer, *line, inbox);
  if (const auto* values = std::get_if<TextValues>(&*line))
    return take_values(arrival, *device, *values, inbox);
  device->header = std::get<TextHeader>(*line);
  device->columns = 0;
  device->other = {};
  device->clock.restart();
  inbox.alive = {device->id, 0};
  return Verdict::taken;
}

Verdict EyewearProtocol::take_line_of_candidate(HostTime arrival, sensor::Peer peer, const TextLine& line,
                                                Inbox& inbox) {
  const auto* values = std::get_if<TextValues>(&line);
  if (values == nullptr) {
    TextCandidate& candidate = meet(peer, arrival);
    candidate = {.peer = peer, .header = std::get<TextHeader>(line), .received = arrival};
    return Verdict::taken;
  }
  const auto known = std::ranges::find(candidates_, peer, &TextCandidate::peer);
  // A malformed line leaves no trace, not even its sender: logs lack it, and a replay must decode alike.
  if (!is_sound(*values, known != candidates_.end() ? known->header : TextHeader()))
    return Verdict::malformed;
  TextCandidate& candidate = meet(peer, arrival);
  candidate.received = arrival;
  if (!candidate.run.add(values->count)) return Verdict::taken;
  TextDevice* const device = accept(arrival, candidate);
  if (device == nullptr) return Verdict::ignored;
  candidate = candidates_.back();
  candidates_.pop_back();
  return take_values(arrival, *device, *values, inbox);
}

Verdict EyewearProtocol::take_values(HostTime arrival, TextDevice& device, const TextValues& line,
                                     Inbox& inbox) const {
  if (!is_sound(line, device.header)) return Verdict::malformed;
  const std::size_t per_channel = device.header.pairs ? 2 : 1;
  const std::int32_t most = full_scale(device.header);
  const auto values = std::span(line.values).first(line.count);

  // Malformed lines leave the state unchanged: logs lack them, and a replay must decode alike.
  if (values.size() != device.columns) {
    if (device.columns != 0 && arrival - device.accepted < kDoubt) return Verdict::malformed;
    if (!device.other.add(values.size())) {
      inbox.alive = {device.id, 0};
      return Verdict::taken;
    }
    device.columns = values.size();
  }
  device.accepted = arrival;
  device.other = {};

  ++device.lines;
  sensor::Sample sample;
  sample.kind = sensor::SampleKind::eyewear_light;
  sample.sequence = static_cast<std::uint32_t>(device.lines);
  sample.time = device.clock.add(arrival, device.lines);
  sample.time_estimated = true;
  sample.count = 2;
  for (std::size_t c = 0; c < values.size() / per_channel; ++c) {
    // A difference alone becomes the LED-on value; a negative one, by noise, the LED-off value: on less off
    // stays the same.
    const std::int32_t on = per_channel == 2 ? values[2 * c] : std::max(values[c], 0);
    const std::int32_t off = per_channel == 2 ? values[2 * c + 1] : std::max(-values[c], 0);
    sample.values[0] = static_cast<float>(static_cast<double>(on) / most);
    sample.values[1] = static_cast<float>(static_cast<double>(off) / most);
    inbox.readings.push_back({.from = {device.id, static_cast<std::uint8_t>(c)},
                              .sample = sample,
                              .saturated = std::max(on, off) == most});
  }
  return Verdict::taken;
}

}  // namespace mien::eyewear
