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

/// Most markers of one server: those that fit into one datagram.
inline constexpr std::size_t kMaxPacketMarkers = 100;
inline constexpr std::size_t kMaxMarkerNameBytes = 64;

/// Names of a motion capture server's markers, sent now and then, in as many packets as needed; version 1.
/// Layout, byte by byte, with a test vector: docs/reference/protocol.md.
struct MarkerNamesPacket {
  std::uint64_t device = 0;  ///< The server's unique number, in all of its packets.
  std::uint32_t list = 0;    ///< marker_list() of all of its markers.
  std::uint8_t markers = 0;  ///< Total number, 1 to kMaxPacketMarkers.
  std::uint8_t first = 0;    ///< Index of the first name in this packet.
  std::uint8_t count = 0;    ///< Names in this packet, 1 or more.
  /// Printable ASCII without commas and quotes, 1 to kMaxMarkerNameBytes of it. Lifetime: the packet's bytes.
  std::array<std::string_view, kMaxPacketMarkers> names{};
};

/// Marker positions at one time, version 1.
struct MarkerPositionsPacket {
  MarkerPositionsPacket() { position_m.fill(Vec3f::Zero()); }
  std::uint64_t device = 0;
  std::uint32_t sequence = 0;  ///< Counts these packets; wraps.
  std::uint32_t list = 0;      ///< marker_list() of the names in whose order the positions are.
  DeviceTime time;             ///< The server's clock; whole microseconds, 0 to 1e14.
  std::uint8_t count = 0;      ///< Markers, 1 to kMaxPacketMarkers.
  /// Metres, whole micrometres, within kMaxTrackPositionM, the cameras' right-handed frame; kLostMarker where
  /// lost.
  std::array<Vec3f, kMaxPacketMarkers> position_m;
};

using MarkerPacket = std::variant<MarkerNamesPacket, MarkerPositionsPacket>;

/// Whether the bytes begin like one of these; checks no more.
[[nodiscard]] bool is_marker_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, reserved bytes, a name, half a position);
/// unsupported (version, type); out_of_range (numbers of markers, time, a position). No allocation but in
/// errors. Thread-safe.
[[nodiscard]] Result<MarkerPacket> parse_marker_packet(std::span<const std::byte> bytes);

/// Identifies a list of names: CRC-32 over the names, each followed by a line feed.
[[nodiscard]] std::uint32_t marker_list(std::span<const std::string> names);

/// The datagrams with these names, each of at most 1200 bytes. Errors: out_of_range, malformed, as
/// parse_marker_packet.
[[nodiscard]] Result<std::vector<std::vector<std::byte>>> encode_marker_names(
    std::uint64_t device, std::span<const std::string> names);
/// The datagram of one time. Errors: as parse_marker_packet, for invalid fields.
[[nodiscard]] Result<std::vector<std::byte>> encode_marker_positions(const MarkerPositionsPacket& packet);

}  // namespace mien::mocap
