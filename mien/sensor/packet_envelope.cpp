#include "mien/sensor/packet_envelope.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace mien::sensor {
namespace {

constexpr std::array<std::byte, 4> kMagic = {std::byte{'M'}, std::byte{'I'}, std::byte{'E'}, std::byte{'N'}};
constexpr std::size_t kVersionAt = 4, kTypeAt = 5;
constexpr std::uint64_t kMaxTimeUs = 100'000'000'000'000;

}  // namespace

bool is_our_packet(std::span<const std::byte> bytes) {
  return bytes.size() > kTypeAt && std::equal(kMagic.begin(), kMagic.end(), bytes.begin());
}

bool is_our_packet(std::span<const std::byte> bytes, std::uint8_t type) {
  return is_our_packet(bytes) && bytes[kTypeAt] == std::byte{type};
}

std::optional<unsigned> unknown_packet_version(std::span<const std::byte> bytes) {
  if (!is_our_packet(bytes)) return std::nullopt;
  const auto version = std::to_integer<unsigned>(bytes[kVersionAt]);
  return version == kPacketVersion ? std::nullopt : std::optional(version);
}

Result<std::uint8_t> read_packet_begin(ByteReader& reader, const char* where) {
  if (!std::ranges::equal(reader.take(kMagic.size()), kMagic))
    return fail(ErrorCode::malformed, "not a packet of ours", where);
  const auto version = reader.little<std::uint8_t>();
  if (version != kPacketVersion)
    return fail(ErrorCode::unsupported, fmt::format("version {} is unknown", version), where,
                "update this program or the device");
  return reader.little<std::uint8_t>();
}

Result<void> read_packet_begin(ByteReader& reader, std::uint8_t type, const char* other, const char* where) {
  MIEN_TRY_ASSIGN(const std::uint8_t its, read_packet_begin(reader, where));
  if (its == type) return {};
  return fail(ErrorCode::unsupported, fmt::format("packet type {} is {}", its, other), where);
}

Result<void> check_checksum(std::span<const std::byte> packet, const char* where) {
  ByteReader checksum(packet.last(kChecksumBytes));
  if (checksum.little<std::uint32_t>() != crc32(packet.first(packet.size() - kChecksumBytes)))
    return fail(ErrorCode::malformed, "the checksum does not match", where);
  return {};
}

Result<void> check_length(std::size_t bytes, std::size_t expected, const char* where) {
  if (bytes == expected) return {};
  return fail(bytes < expected ? ErrorCode::truncated : ErrorCode::malformed,
              fmt::format("{} bytes, not {}", bytes, expected), where);
}

void write_packet_begin(std::uint8_t type, ByteWriter& out) {
  out.append(kMagic);
  out.little(kPacketVersion);
  out.little(type);
}

void write_checksum(std::size_t begin, ByteWriter& out) {
  out.little(crc32(out.bytes().subspan(begin)));
}

Result<DeviceTime> read_device_time(ByteReader& reader, const char* where) {
  const auto time_us = reader.little<std::uint64_t>();
  if (time_us > kMaxTimeUs) return fail(ErrorCode::out_of_range, "a device time out of range", where);
  return DeviceTime(std::chrono::microseconds(static_cast<std::int64_t>(time_us)));
}

Result<void> check_device_time(DeviceTime time, const char* where) {
  const std::int64_t time_ns = time.time_since_epoch().count();
  if (time_ns < 0 || time_ns > static_cast<std::int64_t>(kMaxTimeUs) * 1000)
    return fail(ErrorCode::out_of_range, "a device time out of range", where);
  return {};
}

void write_device_time(DeviceTime time, ByteWriter& out) {
  out.little(static_cast<std::uint64_t>((time.time_since_epoch().count() + 500) / 1000));
}

std::uint8_t share_steps(float share) {
  return static_cast<std::uint8_t>(std::lround(share * kShareSteps));
}

float share_of(std::uint8_t steps) {
  return static_cast<float>(steps) / kShareSteps;
}

Result<void> check_battery(std::uint8_t percent, const char* where) {
  if (percent > 100 && percent != kBatteryUnknown)
    return fail(ErrorCode::out_of_range, "a battery above 100 percent", where);
  return {};
}

}  // namespace mien::sensor
