#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mien/core/bytes.h"
#include "mien/core/error.h"
#include "mien/core/time.h"

// What all packets of our own have in common, whatever stands in them: they begin with "MIEN", a version and
// a type, and end with a checksum of all before it. Layout: docs/reference/protocol.md. `where` names the
// packet in messages. No allocation but in errors. Thread-safe.
namespace mien::sensor {

inline constexpr std::uint8_t kPacketVersion = 1;
inline constexpr std::size_t kChecksumBytes = 4;
/// A battery's percentage that is not known.
inline constexpr std::uint8_t kBatteryUnknown = 255;

/// True when the bytes begin as a packet of ours and are long enough to say its type.
[[nodiscard]] bool is_our_packet(std::span<const std::byte> bytes);
/// The same of one type.
[[nodiscard]] bool is_our_packet(std::span<const std::byte> bytes, std::uint8_t type);

/// The version of a packet of ours, where it is another than kPacketVersion.
[[nodiscard]] std::optional<unsigned> unknown_packet_version(std::span<const std::byte> bytes);
/// Reads the packet's beginning and gives its type. Errors: malformed (magic), unsupported (version).
[[nodiscard]] Result<std::uint8_t> read_packet_begin(ByteReader& reader, const char* where);
/// The same where it must be of this type; `other` says what another one is not. Errors: unsupported too
/// (type).
[[nodiscard]] Result<void> read_packet_begin(ByteReader& reader, std::uint8_t type, const char* other,
                                             const char* where);
/// Whether the packet ends with its checksum. Errors: malformed. It has kChecksumBytes or more.
[[nodiscard]] Result<void> check_checksum(std::span<const std::byte> packet, const char* where);
/// Errors: truncated, malformed (too long).
[[nodiscard]] Result<void> check_length(std::size_t bytes, std::size_t expected, const char* where);

void write_packet_begin(std::uint8_t type, ByteWriter& out);
/// Closes the packet that began where `out` had `begin` bytes.
void write_checksum(std::size_t begin, ByteWriter& out);

/// Device times stand as whole microseconds from 0 to 1e14, three years: frame numbers of them stay exact.
/// Errors: out_of_range.
[[nodiscard]] Result<DeviceTime> read_device_time(ByteReader& reader, const char* where);
[[nodiscard]] Result<void> check_device_time(DeviceTime time, const char* where);
/// Rounds to microseconds.
void write_device_time(DeviceTime time, ByteWriter& out);

/// A share from 0 to 1 stands in one byte as so many steps; one more says that it is not known.
inline constexpr std::uint8_t kShareSteps = 254;
inline constexpr std::uint8_t kShareUnknown = 255;
/// The nearest step. `share`: 0 to 1.
[[nodiscard]] std::uint8_t share_steps(float share);
/// `steps`: at most kShareSteps.
[[nodiscard]] float share_of(std::uint8_t steps);

/// 0 to 100, or kBatteryUnknown. Errors: out_of_range.
[[nodiscard]] Result<void> check_battery(std::uint8_t percent, const char* where);

}  // namespace mien::sensor
