#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mien/core/bytes.h"
#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/sensor/protocol.h"

namespace mien::headset {

/// What stands beside a camera's picture, which is its payload, in a session's log: a datagram, type 15,
/// version 1. Layout, byte by byte, with a test vector: docs/reference/protocol.md.
struct PicturePacket {
  sensor::DeviceKey from;
  std::uint32_t sequence = 0;  ///< Counts the camera's pictures, those that were lost too; wraps.
  /// Of the camera's clock, when the picture was read out: whole microseconds, 0 to 1e14. None: it told none.
  std::optional<DeviceTime> time;
  bool first = false;  ///< Of its connection: the camera's clock may have begun anew.
  bool operator==(const PicturePacket&) const = default;
};

inline constexpr std::size_t kPicturePacketBytes = 36;

/// Whether the bytes begin like a picture's packet; checks no more.
[[nodiscard]] bool is_picture_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, flags, reserved bytes, a time where none is);
/// unsupported (version, type); out_of_range (time). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<PicturePacket> parse_picture_packet(std::span<const std::byte> bytes);

/// Inverse of parse_picture_packet, to the byte, behind what `out` has; times are rounded to microseconds.
/// Errors: out_of_range (time); `out` is then as it was.
[[nodiscard]] Result<void> write_picture_packet(const PicturePacket& packet, ByteWriter& out);

}  // namespace mien::headset
