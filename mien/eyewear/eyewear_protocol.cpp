#include "mien/eyewear/eyewear_protocol.h"

#include <algorithm>
#include <array>
#include <cstdlib>

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
  devices_.reserve(kMaxTextDevices);
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

EyewearProtocol::TextDevice* EyewearProtocol::device_of(sensor::Peer peer) {
  const auto known = std::ranges::find(devices_, peer, &TextDevice::peer);
  if (known != devices_.end()) return &*known;
  if (devices_.size() == kMaxTextDevices) return nullptr;
  devices_.push_back(
      {.peer = peer, .id = kTextDevice + devices_.size(), .clock = sensor::EstimatedClock(kTextClock)});
  return &devices_.back();
}

std::uint8_t EyewearProtocol::bits_of(const TextDevice& device) const {
  return device.header.adc_bits != 0 ? device.header.adc_bits : settings_.text_bits;
}

Verdict EyewearProtocol::take_line(HostTime arrival, sensor::Peer peer, std::span<const std::byte> bytes,
                                   Inbox& inbox) {
  const auto line = parse_text_line(bytes);
  if (!line) return Verdict::malformed;
  const std::size_t met = devices_.size();
  TextDevice* device = device_of(peer);
  if (device == nullptr) return Verdict::refused;
  if (std::holds_alternative<TextComment>(*line)) return Verdict::ignored;
  if (const auto* header = std::get_if<TextHeader>(&*line)) {
    device->header = *header;
    device->columns = 0;
    device->candidate = 0;
    device->agreed = 0;
    device->clock.restart();
    inbox.alive = {device->id, 0};
    return Verdict::taken;
  }
  const Verdict verdict = take_values(arrival, *device, std::get<TextValues>(*line), inbox);
  // A malformed line creates no device: logs lack it, so a replay would number devices differently.
  if (verdict == Verdict::malformed && devices_.size() > met) devices_.pop_back();
  return verdict;
}

Verdict EyewearProtocol::take_values(HostTime arrival, TextDevice& device, const TextValues& line,
                                     Inbox& inbox) const {
  const std::size_t per_channel = device.header.pairs ? 2 : 1;
  const std::int32_t full_scale = (1 << bits_of(device)) - 1;
  const auto values = std::span(line.values).first(line.count);
  const auto within = [&](std::int32_t value) {
    return std::abs(value) <= full_scale && (value >= 0 || per_channel == 1);
  };
  if (values.size() % per_channel != 0 || values.size() > per_channel * kMaxChannels ||
      !std::ranges::all_of(values, within))
    return Verdict::malformed;

  // Malformed lines leave the state unchanged: logs lack them, and a replay must decode alike.
  if (values.size() != device.columns) {
    if (device.columns != 0 && arrival - device.accepted < kDoubt) return Verdict::malformed;
    device.agreed = device.candidate == values.size() ? device.agreed + 1 : 1;
    device.candidate = values.size();
    if (device.agreed < kAgreed) {
      inbox.alive = {device.id, 0};
      return Verdict::taken;
    }
    device.columns = values.size();
  }
  device.accepted = arrival;
  device.agreed = 0;

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
    sample.values[0] = static_cast<float>(static_cast<double>(on) / full_scale);
    sample.values[1] = static_cast<float>(static_cast<double>(off) / full_scale);
    inbox.readings.push_back({.from = {device.id, static_cast<std::uint8_t>(c)},
                              .sample = sample,
                              .saturated = std::max(on, off) == full_scale});
  }
  return Verdict::taken;
}

}  // namespace mien::eyewear
