#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/phone/told_face.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::phone {

/// What another program says of a face at one moment, version 1: a datagram, type 12. Layout, byte by byte,
/// with a test vector: docs/reference/protocol.md.
struct Packet {
  std::uint64_t device = 0;                                ///< Unique: a MAC in the low 48 bits.
  std::uint32_t sequence = 0;                              ///< Counts these packets; wraps.
  std::uint8_t battery_percent = sensor::kBatteryUnknown;  ///< 0 to 100, or unknown.
  DeviceTime time;  ///< Middle of the exposure, the sender's clock; whole microseconds, 0 to 1e14.
  ToldFace face;    ///< Confidences in steps of 1/254.
  bool operator==(const Packet&) const = default;
};

/// Without a weight and a head.
inline constexpr std::size_t kLeastPacketBytes = 52;
/// All of the largest set, with confidences and a head.
inline constexpr std::size_t kMostPacketBytes = kLeastPacketBytes + 5 * kMostShapes + 28;

/// Whether the bytes begin like a packet of weights; checks no more.
[[nodiscard]] bool is_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, flags, a shape that the set does not have);
/// unsupported (version, type, a set of another version); mismatch (the sender's set has other names or
/// another order); out_of_range (battery, time, origin, a weight, confidence, position or rotation that is
/// not finite or beyond its range). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<Packet> parse_packet(std::span<const std::byte> bytes);

/// Inverse of parse_packet, to the byte (but where confidences were announced and none was told); times are
/// rounded to microseconds, confidences to the wire's steps. Errors: out_of_range.
[[nodiscard]] Result<std::vector<std::byte>> encode_packet(const Packet& packet);

}  // namespace mien::phone
