#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/rotation.h"
#include "mien/core/time.h"

namespace mien::mocap {

/// Markers of one server: as many as fit into one datagram.
inline constexpr std::size_t kMaxPacketMarkers = 100;
inline constexpr std::size_t kMaxMarkerNameBytes = 64;

/// What a motion capture server says of its markers now and then, version 1: their names, in as many packets
/// as it takes. Layout, byte by byte, with a test vector: docs/reference/protocol.md.
struct MarkerNamesPacket {
  std::uint64_t device = 0;  ///< The server's; the same for all packets of it and for nobody else's.
  std::uint32_t list = 0;    ///< marker_list() of all of its markers.
  std::uint8_t markers = 0;  ///< In all, 1 to kMaxPacketMarkers.
  std::uint8_t first = 0;    ///< Number of the first name here.
  std::uint8_t count = 0;    ///< Names here, 1 or more.
  /// Printable ASCII without commas and quotes, 1 to kMaxMarkerNameBytes of it. Lifetime: the packet's bytes.
  std::array<std::string_view, kMaxPacketMarkers> names{};
};

/// Where the markers are at one moment, version 1.
struct MarkerPositionsPacket {
  MarkerPositionsPacket() { position_m.fill(Vec3f::Zero()); }
  std::uint64_t device = 0;
  std::uint32_t sequence = 0;  ///< Counts these packets; wraps.
  std::uint32_t list = 0;      ///< Whose names stand for the numbers.
  DeviceTime time;             ///< The server's clock; whole microseconds, 0 to 1e14.
  std::uint8_t count = 0;      ///< Markers, 1 to kMaxPacketMarkers.
  /// Metres, whole micrometres, within kMaxTrackPositionM, the cameras' right-handed frame; kLostMarker where
  /// lost.
  std::array<Vec3f, kMaxPacketMarkers> position_m;
};

using MarkerPacket = std::variant<MarkerNamesPacket, MarkerPositionsPacket>;

/// True when the bytes begin as one of these does; says nothing about the rest.
[[nodiscard]] bool is_marker_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, reserved bytes, a name, half a position);
/// unsupported (version, type); out_of_range (numbers of markers, time, a position). No allocation but in
/// errors. Thread-safe.
[[nodiscard]] Result<MarkerPacket> parse_marker_packet(std::span<const std::byte> bytes);

/// What tells one list of names from another: their CRC-32, each followed by a line feed.
[[nodiscard]] std::uint32_t marker_list(std::span<const std::string> names);

/// The datagrams that tell these names, each of at most 1200 bytes. Errors: out_of_range, malformed: what
/// parse_marker_packet would find.
[[nodiscard]] Result<std::vector<std::vector<std::byte>>> encode_marker_names(
    std::uint64_t device, std::span<const std::string> names);
/// The datagram of one moment. Errors: those that parse_marker_packet would find.
[[nodiscard]] Result<std::vector<std::byte>> encode_marker_positions(const MarkerPositionsPacket& packet);

}  // namespace mien::mocap
