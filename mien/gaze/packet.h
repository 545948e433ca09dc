#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/gaze/eyes.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::gaze {

/// Where both eyes look at one moment, version 1: a datagram, type 11. Layout, byte by byte, with test
/// vectors: docs/reference/protocol.md.
struct Packet {
  std::uint64_t device = 0;                                ///< Unique: a MAC in the low 48 bits.
  std::uint32_t sequence = 0;                              ///< Counts these packets; wraps.
  std::uint8_t battery_percent = sensor::kBatteryUnknown;  ///< 0 to 100, or unknown.
  DeviceTime time;  ///< Middle of the exposure, the sender's clock; whole microseconds, 0 to 1e14.
  Eyes eyes;        ///< In steps of the wire: confidence and openness 1/254, pupil 0.01 mm.
  bool operator==(const Packet&) const = default;
};

inline constexpr std::size_t kPacketBytes = 60;

/// Whether the bytes begin like a gaze packet; checks no more.
[[nodiscard]] bool is_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, reserved bytes); unsupported (version, type);
/// out_of_range (battery, time, an angle beyond a quarter turn or not finite, a confidence or pupil beyond
/// its range). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<Packet> parse_packet(std::span<const std::byte> bytes);

/// Inverse of parse_packet, to the byte; times are rounded to microseconds, confidence, openness and pupil to
/// the wire's steps. Errors: out_of_range.
[[nodiscard]] Result<std::vector<std::byte>> encode_packet(const Packet& packet);

}  // namespace mien::gaze
