#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/sensor/packet_envelope.h"
#include "mien/sensor/sample.h"

namespace mien::eyewear {

inline constexpr std::size_t kMaxChannels = 64;
inline constexpr std::uint8_t kMinAdcBits = 8;
inline constexpr std::uint8_t kMaxAdcBits = 16;
using sensor::kBatteryUnknown;

/// One photo-reflective sensor's readings in a scan, converter steps, 0 to 2^bits - 1.
struct Light {
  std::uint16_t on = 0;   ///< With its LED on: reflection and ambient light.
  std::uint16_t off = 0;  ///< With its LED off: ambient light.
  bool operator==(const Light&) const = default;
};

/// One scan of all sensors of a pair of smart eyewear, version 1. Over UDP a datagram, on a serial line a
/// COBS frame. Layout, byte by byte, with a test vector: docs/reference/protocol.md.
struct Packet {
  std::uint8_t channels = 0;                       ///< Sensors, 1 to kMaxChannels.
  std::uint8_t adc_bits = 10;                      ///< Of the converter, kMinAdcBits to kMaxAdcBits.
  std::uint64_t device = 0;                        ///< Unique: the board's MAC in the low 48 bits.
  std::uint32_t sequence = 0;                      ///< Counts scans; wraps.
  std::uint8_t battery_percent = kBatteryUnknown;  ///< 0 to 100, or kBatteryUnknown.
  DeviceTime time;                                 ///< Middle of the scan; whole microseconds, 0 to 1e14.
  std::array<Light, kMaxChannels> light{};         ///< Of each channel; those beyond `channels` are zero.

  /// The converter's highest value: a saturated reading.
  [[nodiscard]] std::uint16_t full_scale() const { return static_cast<std::uint16_t>((1U << adc_bits) - 1U); }
  bool operator==(const Packet&) const = default;
};

/// Whether the bytes begin like an eyewear packet; checks no more.
[[nodiscard]] bool is_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, reserved bytes); unsupported (version, type);
/// out_of_range (channels, bits, battery, time, a value beyond the converter's range). No allocation but in
/// errors. Thread-safe.
[[nodiscard]] Result<Packet> parse_packet(std::span<const std::byte> bytes);

/// Inverse of parse_packet, to the byte; times are rounded to microseconds. Errors: as parse_packet, for
/// invalid fields.
[[nodiscard]] Result<std::vector<std::byte>> encode_packet(const Packet& packet);

/// A packet of one scan, for simulated devices: one sample a channel, in channel order, 1 to kMaxChannels,
/// with equal time and sequence. Light is rounded to steps and saturates at 0 and 1. Errors: bad_usage (none,
/// too many, another kind, unequal times or sequences), out_of_range (bits, values that are not finite).
[[nodiscard]] Result<Packet> make_packet(std::span<const sensor::Sample> scan, std::uint8_t adc_bits);

/// The sample of one channel (below `channels`) as that of sensor number `sensor` of a rig.
[[nodiscard]] sensor::Sample sample_of(const Packet& packet, std::size_t channel, std::uint16_t sensor);

/// Whether the channel's reading, LED on or off, is at the upper end of the converter's range.
[[nodiscard]] bool is_saturated(const Packet& packet, std::size_t channel);

}  // namespace mien::eyewear
