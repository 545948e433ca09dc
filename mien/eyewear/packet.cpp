#include "mien/eyewear/packet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mien/core/bytes.h"

namespace mien::eyewear {
namespace {

using sensor::kChecksumBytes;
using sensor::Sample;
using sensor::SampleKind;

constexpr std::uint8_t kTypeEyewear = 8;
constexpr std::size_t kHeaderBytes = 32;
constexpr std::size_t kChannelBytes = 4;
constexpr std::size_t kReservedBytes = 3;

const char* const kEyewearPacket = "eyewear packet";

/// Checks for parsing and encoding.
Result<void> check(const Packet& packet) {
  if (packet.channels < 1 || packet.channels > kMaxChannels)
    return fail(ErrorCode::out_of_range,
                fmt::format("{} channels, not 1 to {}", packet.channels, kMaxChannels), kEyewearPacket);
  if (packet.adc_bits < kMinAdcBits || packet.adc_bits > kMaxAdcBits)
    return fail(
        ErrorCode::out_of_range,
        fmt::format("a converter of {} bits, not {} to {}", packet.adc_bits, kMinAdcBits, kMaxAdcBits),
        kEyewearPacket);
  MIEN_TRY(sensor::check_battery(packet.battery_percent, kEyewearPacket));
  MIEN_TRY(sensor::check_device_time(packet.time, kEyewearPacket));
  for (std::size_t c = 0; c < packet.channels; ++c)
    if (std::max(packet.light[c].on, packet.light[c].off) > packet.full_scale())
      return fail(ErrorCode::out_of_range, fmt::format("channel {} is beyond the converter's range", c),
                  kEyewearPacket);
  return {};
}

}  // namespace

bool is_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypeEyewear);
}

Result<Packet> parse_packet(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderBytes + kChannelBytes + kChecksumBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes are too few", bytes.size()), kEyewearPacket);
  ByteReader reader(bytes);
  MIEN_TRY(sensor::read_packet_begin(reader, kTypeEyewear, "not eyewear's", kEyewearPacket));

  Packet packet;
  packet.channels = reader.little<std::uint8_t>();
  packet.adc_bits = reader.little<std::uint8_t>();
  packet.device = reader.little<std::uint64_t>();
  packet.sequence = reader.little<std::uint32_t>();
  packet.battery_percent = reader.little<std::uint8_t>();
  const auto reserved = reader.take(kReservedBytes);
  if (std::ranges::any_of(reserved, [](std::byte b) { return b != std::byte{0}; }))
    return fail(ErrorCode::malformed, "a reserved byte is set", kEyewearPacket);
  MIEN_TRY_ASSIGN(packet.time, sensor::read_device_time(reader, kEyewearPacket));

  // First the fields that determine the length and the range.
  MIEN_TRY(check(packet));
  const std::size_t expected = kHeaderBytes + packet.channels * kChannelBytes + kChecksumBytes;
  MIEN_TRY(sensor::check_length(bytes.size(), expected, kEyewearPacket));
  MIEN_TRY(sensor::check_checksum(bytes, kEyewearPacket));

  for (std::size_t c = 0; c < packet.channels; ++c) {
    packet.light[c].on = reader.little<std::uint16_t>();
    packet.light[c].off = reader.little<std::uint16_t>();
  }
  MIEN_TRY(check(packet));
  return packet;
}

Result<std::vector<std::byte>> encode_packet(const Packet& packet) {
  MIEN_TRY(check(packet));
  ByteWriter writer;
  sensor::write_packet_begin(kTypeEyewear, writer);
  writer.little(packet.channels);
  writer.little(packet.adc_bits);
  writer.little(packet.device);
  writer.little(packet.sequence);
  writer.little(packet.battery_percent);
  for (std::size_t i = 0; i < kReservedBytes; ++i) writer.little(std::uint8_t{0});
  sensor::write_device_time(packet.time, writer);
  for (std::size_t c = 0; c < packet.channels; ++c) {
    writer.little(packet.light[c].on);
    writer.little(packet.light[c].off);
  }
  sensor::write_checksum(0, writer);
  return writer.release();
}

Result<Packet> make_packet(std::span<const Sample> scan, std::uint8_t adc_bits) {
  if (scan.empty() || scan.size() > kMaxChannels)
    return fail(ErrorCode::bad_usage, fmt::format("{} samples do not make a scan", scan.size()),
                kEyewearPacket);
  Packet packet;
  packet.channels = static_cast<std::uint8_t>(scan.size());
  packet.adc_bits = adc_bits;
  packet.sequence = scan.front().sequence;
  packet.time = scan.front().time;
  MIEN_TRY(check(packet));
  const auto steps = [&](float share) {
    const float within = std::clamp(share, 0.0F, 1.0F);
    return static_cast<std::uint16_t>(std::lround(static_cast<double>(within) * packet.full_scale()));
  };
  for (std::size_t c = 0; c < scan.size(); ++c) {
    const Sample& sample = scan[c];
    if (sample.kind != SampleKind::eyewear_light || sample.count != 2 || sample.time != packet.time ||
        sample.sequence != packet.sequence)
      return fail(ErrorCode::bad_usage, "samples that do not belong in one scan", kEyewearPacket);
    if (!std::isfinite(sample.values[0]) || !std::isfinite(sample.values[1]))
      return fail(ErrorCode::out_of_range, "a value that is not finite", kEyewearPacket);
    packet.light[c] = {steps(sample.values[0]), steps(sample.values[1])};
  }
  return packet;
}

Sample sample_of(const Packet& packet, std::size_t channel, std::uint16_t sensor) {
  const auto share = [&](std::uint16_t steps) {
    return static_cast<float>(static_cast<double>(steps) / packet.full_scale());
  };
  Sample sample;
  sample.sensor = sensor;
  sample.kind = SampleKind::eyewear_light;
  sample.sequence = packet.sequence;
  sample.time = packet.time;
  sample.count = 2;
  sample.values[0] = share(packet.light[channel].on);
  sample.values[1] = share(packet.light[channel].off);
  return sample;
}

bool is_saturated(const Packet& packet, std::size_t channel) {
  return std::max(packet.light[channel].on, packet.light[channel].off) >= packet.full_scale();
}

}  // namespace mien::eyewear
