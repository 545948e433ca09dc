#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/sensor/packet_envelope.h"
#include "mien/sensor/sample.h"

namespace mien::imu {

inline constexpr std::size_t kMaxPacketSamples = 16;
using sensor::kBatteryUnknown;

/// One datagram of samples of an IMU node, version 1. Values are SI, frame S; on the wire raw axes are the
/// chip's 16-bit steps. Layout, byte by byte, with test vectors: docs/reference/protocol.md.
struct Packet {
  sensor::SampleKind kind = sensor::SampleKind::imu_raw;
  bool magnetometer = false;                       ///< Raw axes only: nine values a sample, else six.
  bool time_estimated = false;                     ///< The device time was estimated by the packet's sender.
  std::uint64_t device = 0;                        ///< Unique: the board's MAC in the low 48 bits.
  std::uint8_t channel = 0;                        ///< Sensor of the board, from 0.
  std::uint32_t sequence = 0;                      ///< Counts this channel's packets; wraps.
  std::uint8_t battery_percent = kBatteryUnknown;  ///< 0 to 100, or kBatteryUnknown.
  std::uint8_t gyro_range = 6;   ///< Code 0 to 6: full scale 16 * 2^code deg/s; 0 without raw axes.
  std::uint8_t accel_range = 2;  ///< Code 0 to 3: full scale 2 * 2^code g (9.80665 m/s^2); likewise.
  DeviceTime time;               ///< Middle of the first sample; whole microseconds, 0 to 1e14.
  Duration interval{};           ///< Between samples, ns; 0 only when there is one sample. At most a second.
  std::uint8_t count = 0;        ///< Samples, 1 to 16.
  /// Of each sample the first values_per_sample(); order and units: sensor::SampleKind.
  std::array<std::array<float, 9>, kMaxPacketSamples> values{};

  [[nodiscard]] std::size_t values_per_sample() const;
  bool operator==(const Packet&) const = default;
};

/// Value of one step of a raw axis.
[[nodiscard]] double gyro_step_rad_s(std::uint8_t range_code);
[[nodiscard]] double accel_step_m_s2(std::uint8_t range_code);
inline constexpr double kMagStepTesla = 1e-7;

/// Whether the bytes begin like an IMU packet; checks no more.
[[nodiscard]] bool is_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, reserved bits, no unit quaternion); unsupported
/// (version, type, kind); out_of_range (count, range code, battery, time, interval, a number not finite or
/// absurd). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<Packet> parse_packet(std::span<const std::byte> bytes);

/// Inverse of parse_packet, to the byte. Raw axes are rounded to steps and saturate as the chip does; times
/// are rounded to microseconds. Errors: as parse_packet, for invalid fields.
[[nodiscard]] Result<std::vector<std::byte>> encode_packet(const Packet& packet);

/// A packet of evenly spaced samples of one kind, 1 to 16, for simulated devices. Errors: bad_usage (none,
/// too many, mixed kinds or counts, times that do not rise).
[[nodiscard]] Result<Packet> make_packet(std::span<const sensor::Sample> samples);

/// Whether a raw axis of sample `sample` is at the end of its range.
[[nodiscard]] bool is_saturated(const Packet& packet, std::size_t sample);

/// The packet's samples as those of sensor number `sensor` of a rig, appended to `out`.
void append_samples(const Packet& packet, std::uint16_t sensor, std::vector<sensor::Sample>& out);

}  // namespace mien::imu
