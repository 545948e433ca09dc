#include "mien/imu/packets/packet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/bytes.h"

namespace mien::imu {
namespace {

using sensor::kChecksumBytes;
using sensor::Sample;
using sensor::SampleKind;

constexpr std::uint8_t kTypeImu = 1;
constexpr std::uint8_t kFlagMagnetometer = 1U << 0U;
constexpr std::uint8_t kFlagTimeEstimated = 1U << 1U;
constexpr std::size_t kImuHeaderBytes = 36;
constexpr std::uint32_t kMaxIntervalNs = 1'000'000'000;
constexpr std::uint8_t kMaxGyroRange = 6;
constexpr std::uint8_t kMaxAccelRange = 3;
constexpr float kMaxForce = 1000.0F;     // m/s^2; no chip of this class reads a tenth of it.
constexpr float kMaxRotation = 6.2832F;  // A full turn, rad.
constexpr double kImuUnitTolerance = 0.01;

const char* const kImuPacket = "imu packet";

std::size_t sample_bytes(const Packet& packet) {
  return packet.values_per_sample() *
         (packet.kind == SampleKind::imu_raw ? sizeof(std::int16_t) : sizeof(float));
}

/// Checks for parsing and encoding.
Result<void> check(const Packet& packet) {
  if (packet.kind != SampleKind::imu_raw && packet.kind != SampleKind::imu_fused &&
      packet.kind != SampleKind::imu_head_relative)
    return fail(ErrorCode::unsupported,
                fmt::format("sample kind {} is unknown", static_cast<int>(packet.kind)), kImuPacket,
                "update this program or the device");
  if (packet.count < 1 || packet.count > kMaxPacketSamples)
    return fail(ErrorCode::out_of_range,
                fmt::format("{} samples, not 1 to {}", packet.count, kMaxPacketSamples), kImuPacket);
  if (packet.magnetometer && packet.kind != SampleKind::imu_raw)
    return fail(ErrorCode::malformed, "a magnetometer beside fused samples", kImuPacket);
  if (packet.kind != SampleKind::imu_raw && (packet.gyro_range != 0 || packet.accel_range != 0))
    return fail(ErrorCode::malformed, "a range code without raw axes", kImuPacket);
  if (packet.gyro_range > kMaxGyroRange || packet.accel_range > kMaxAccelRange)
    return fail(ErrorCode::out_of_range, "a range code that no chip has", kImuPacket);
  MIEN_TRY(sensor::check_battery(packet.battery_percent, kImuPacket));
  MIEN_TRY(sensor::check_device_time(packet.time, kImuPacket));
  if (packet.interval.count() < 0 || packet.interval.count() > kMaxIntervalNs ||
      (packet.interval.count() == 0 && packet.count > 1))
    return fail(ErrorCode::out_of_range, "a sample interval out of range", kImuPacket);
  for (std::size_t i = 0; i < packet.count; ++i) {
    const auto& values = packet.values[i];
    for (std::size_t k = 0; k < packet.values_per_sample(); ++k)
      if (!std::isfinite(values[k]))
        return fail(ErrorCode::out_of_range, "a number that is not finite", kImuPacket);
    if (packet.kind == SampleKind::imu_fused) {
      double norm2 = 0;
      for (std::size_t k = 0; k < 4; ++k)
        norm2 += static_cast<double>(values[k]) * static_cast<double>(values[k]);
      if (std::abs(std::sqrt(norm2) - 1.0) > kImuUnitTolerance)
        return fail(ErrorCode::malformed, "an orientation that is no unit quaternion", kImuPacket);
      for (std::size_t k = 4; k < 7; ++k)
        if (std::abs(values[k]) > kMaxForce)
          return fail(ErrorCode::out_of_range, "an acceleration out of range", kImuPacket);
    }
    if (packet.kind == SampleKind::imu_head_relative)
      for (std::size_t k = 0; k < 3; ++k)
        if (std::abs(values[k]) > kMaxRotation)
          return fail(ErrorCode::out_of_range, "a rotation of more than a turn", kImuPacket);
  }
  return {};
}

double raw_step(const Packet& packet, std::size_t k) {
  if (k < 3) return gyro_step_rad_s(packet.gyro_range);
  return k < 6 ? accel_step_m_s2(packet.accel_range) : kMagStepTesla;
}

}  // namespace

std::size_t Packet::values_per_sample() const {
  switch (kind) {
    case SampleKind::imu_raw:
      return magnetometer ? 9 : 6;
    case SampleKind::imu_fused:
      return 7;
    case SampleKind::imu_head_relative:
      return 3;
    default:  // Other modalities'.
      return 0;
  }
}

double gyro_step_rad_s(std::uint8_t range_code) {
  return std::ldexp(16.0, range_code) * (std::numbers::pi / 180) / 32768.0;
}
double accel_step_m_s2(std::uint8_t range_code) {
  return std::ldexp(2.0, range_code) * 9.80665 / 32768.0;
}

bool is_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypeImu);
}

Result<Packet> parse_packet(std::span<const std::byte> bytes) {
  if (bytes.size() < kImuHeaderBytes + kChecksumBytes)
    return fail(ErrorCode::truncated, fmt::format("{} bytes are too few", bytes.size()), kImuPacket);
  ByteReader reader(bytes);
  MIEN_TRY(sensor::read_packet_begin(reader, kTypeImu, "not IMU's", kImuPacket));

  Packet packet;
  packet.kind = static_cast<SampleKind>(reader.little<std::uint8_t>());
  const auto flags = reader.little<std::uint8_t>();
  if ((flags & ~(kFlagMagnetometer | kFlagTimeEstimated)) != 0)
    return fail(ErrorCode::malformed, "a reserved flag is set", kImuPacket);
  packet.magnetometer = (flags & kFlagMagnetometer) != 0;
  packet.time_estimated = (flags & kFlagTimeEstimated) != 0;
  packet.device = reader.little<std::uint64_t>();
  packet.sequence = reader.little<std::uint32_t>();
  packet.channel = reader.little<std::uint8_t>();
  packet.count = reader.little<std::uint8_t>();
  packet.battery_percent = reader.little<std::uint8_t>();
  const auto ranges = reader.little<std::uint8_t>();
  packet.gyro_range = ranges & 0x0FU;
  packet.accel_range = static_cast<std::uint8_t>(ranges >> 4U);
  MIEN_TRY_ASSIGN(packet.time, sensor::read_device_time(reader, kImuPacket));
  packet.interval = Duration(reader.little<std::uint32_t>());

  // First the fields that determine the length.
  if (packet.values_per_sample() == 0 || packet.count < 1 || packet.count > kMaxPacketSamples) {
    MIEN_TRY(check(packet));
    return fail(ErrorCode::internal, "a packet without a length", kImuPacket);
  }
  const std::size_t expected = kImuHeaderBytes + packet.count * sample_bytes(packet) + kChecksumBytes;
  MIEN_TRY(sensor::check_length(bytes.size(), expected, kImuPacket));
  MIEN_TRY(sensor::check_checksum(bytes, kImuPacket));

  for (std::size_t i = 0; i < packet.count; ++i)
    for (std::size_t k = 0; k < packet.values_per_sample(); ++k)
      packet.values[i][k] =
          packet.kind == SampleKind::imu_raw
              ? static_cast<float>(static_cast<double>(reader.little<std::int16_t>()) * raw_step(packet, k))
              : reader.little<float>();
  MIEN_TRY(check(packet));
  return packet;
}

Result<std::vector<std::byte>> encode_packet(const Packet& packet) {
  MIEN_TRY(check(packet));
  ByteWriter writer;
  sensor::write_packet_begin(kTypeImu, writer);
  writer.little(static_cast<std::uint8_t>(packet.kind));
  writer.little(static_cast<std::uint8_t>((packet.magnetometer ? kFlagMagnetometer : 0) |
                                          (packet.time_estimated ? kFlagTimeEstimated : 0)));
  writer.little(packet.device);
  writer.little(packet.sequence);
  writer.little(packet.channel);
  writer.little(packet.count);
  writer.little(packet.battery_percent);
  writer.little(static_cast<std::uint8_t>(packet.gyro_range | (packet.accel_range << 4U)));
  sensor::write_device_time(packet.time, writer);
  writer.little(static_cast<std::uint32_t>(packet.interval.count()));
  for (std::size_t i = 0; i < packet.count; ++i)
    for (std::size_t k = 0; k < packet.values_per_sample(); ++k) {
      const float value = packet.values[i][k];
      if (packet.kind == SampleKind::imu_raw) {
        const double steps = std::round(static_cast<double>(value) / raw_step(packet, k));
        writer.little(static_cast<std::int16_t>(std::clamp(steps, -32768.0, 32767.0)));
      } else {
        writer.little(value);
      }
    }
  sensor::write_checksum(0, writer);
  return writer.release();
}

Result<Packet> make_packet(std::span<const Sample> samples) {
  if (samples.empty() || samples.size() > kMaxPacketSamples)
    return fail(ErrorCode::bad_usage, fmt::format("{} samples do not make a packet", samples.size()),
                kImuPacket);
  const Sample& first = samples.front();
  Packet packet;
  packet.kind = first.kind;
  packet.magnetometer = first.kind == SampleKind::imu_raw && first.count == 9;
  packet.time_estimated = first.time_estimated;
  if (packet.kind != SampleKind::imu_raw) packet.gyro_range = packet.accel_range = 0;
  packet.sequence = first.sequence;
  packet.time = first.time;
  packet.count = static_cast<std::uint8_t>(samples.size());
  if (samples.size() > 1) {
    const auto steps = static_cast<std::int64_t>(samples.size() - 1);
    packet.interval = Duration(((samples.back().time - first.time).count() + steps / 2) / steps);
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    if (sample.kind != first.kind || sample.count != packet.values_per_sample() ||
        (i > 0 && sample.time <= samples[i - 1].time))
      return fail(ErrorCode::bad_usage, "samples that do not belong in one packet", kImuPacket);
    std::copy_n(sample.values.begin(), sample.count, packet.values[i].begin());
  }
  return packet;
}

bool is_saturated(const Packet& packet, std::size_t sample) {
  if (packet.kind != SampleKind::imu_raw) return false;
  for (std::size_t k = 0; k < packet.values_per_sample(); ++k) {
    // Computed as in the parser, so that the range's ends are equal to the bit.
    const float value = packet.values[sample][k];
    if (value >= static_cast<float>(32767.0 * raw_step(packet, k)) ||
        value <= static_cast<float>(-32768.0 * raw_step(packet, k)))
      return true;
  }
  return false;
}

void append_samples(const Packet& packet, std::uint16_t sensor, std::vector<Sample>& out) {
  for (std::size_t i = 0; i < packet.count; ++i) {
    Sample sample;
    sample.sensor = sensor;
    sample.kind = packet.kind;
    sample.sequence = packet.sequence;
    sample.time = packet.time + static_cast<std::int64_t>(i) * packet.interval;
    sample.time_estimated = packet.time_estimated;
    sample.count = static_cast<std::uint8_t>(packet.values_per_sample());
    std::copy_n(packet.values[i].begin(), sample.count, sample.values.begin());
    out.push_back(sample);
  }
}

}  // namespace mien::imu
