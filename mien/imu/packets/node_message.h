#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/error.h"
#include "mien/core/time.h"

namespace mien::imu {

/// UDP port of the host, to which a node without a known host broadcasts its hello.
inline constexpr std::uint16_t kNodePort = 5005;
/// Interval of hellos until a welcome comes.
inline constexpr Duration kHelloPeriod = std::chrono::seconds(1);

inline constexpr std::size_t kMaxNodeChannels = 16;
inline constexpr std::size_t kMaxNodeText = 64;  ///< Most bytes of a site, firmware or host name.

/// Messages between Mien's IMU nodes and their host, besides samples; version 1. Layout, byte by byte, with
/// test vectors: docs/reference/protocol.md. All texts are printable ASCII of at most kMaxNodeText
/// characters.
///
/// Node to all, or to its configured host: announces the node and its channels.
struct Hello {
  std::uint64_t device = 0;
  double rate_hz = 240;  ///< Samples a second of each channel, 1 to 10,000; the wire has thousandths.
  std::string firmware;  ///< For people; may be empty.
  std::vector<std::string> sites;  ///< One a channel, from channel 0: the rig's name of its site, or empty. 1
                                   ///< to kMaxNodeChannels.
  bool operator==(const Hello&) const = default;
};

/// Host to node, the reply to hello: starts the node's samples.
struct Welcome {
  std::uint64_t device = 0;  ///< The addressed node.
  /// Random token of the session, never 0: a node that receives another one sends a hello.
  std::uint64_t session = 0;
  /// Interval of the node's heartbeats, whole ms, 100 to 10,000.
  Duration heartbeat = std::chrono::milliseconds(500);
  std::string host;  ///< For people; may be empty.
  bool operator==(const Welcome&) const = default;
};

/// Node to host: keep-alive.
struct NodeHeartbeat {
  std::uint64_t device = 0;
  std::uint8_t battery_percent = 255;  ///< 0 to 100, or kBatteryUnknown.
  DeviceTime time;                     ///< Now, by the node's clock; whole microseconds.
  bool operator==(const NodeHeartbeat&) const = default;
};

/// Host to node, the reply to a heartbeat: its time again, from which the node measures the round trip.
struct HeartbeatEcho {
  std::uint64_t device = 0;
  DeviceTime time;  ///< The heartbeat's.
  std::uint64_t session = 0;
  bool operator==(const HeartbeatEcho&) const = default;
};

/// Node to host: time of an edge on the sync wire that all nodes share, on the node's own clock, independent
/// of radio latency.
struct Pulse {
  std::uint64_t device = 0;
  std::uint32_t index = 0;  ///< Counts the pulses; the same on every node.
  DeviceTime edge;          ///< Time of the edge; whole microseconds.
  bool operator==(const Pulse&) const = default;
};

using NodeMessage = std::variant<Hello, Welcome, NodeHeartbeat, HeartbeatEcho, Pulse>;

/// The sixth byte of node packets.
enum class NodePacketType : std::uint8_t {
  samples = 1,  ///< imu/packets/packet.h
  hello = 2,
  welcome = 3,
  heartbeat = 4,
  echo = 5,
  pulse = 6,
  sealed = 7,  ///< sensor/seal.h
};

/// Parses any node packet but samples and sealed ones. Errors: truncated; malformed (magic, length, checksum,
/// reserved bytes, text); unsupported (version, type); out_of_range (channels, rate, battery, time, period).
/// Thread-safe.
[[nodiscard]] Result<NodeMessage> parse_node_message(std::span<const std::byte> bytes);

/// Appends the datagram to `out`: the inverse of the parser, to the byte. Errors: as the parser, for invalid
/// fields; `out` is then unchanged. No allocation when `out` has room.
[[nodiscard]] Result<void> encode_node_message(const NodeMessage& message, ByteWriter& out);

/// Whether the bytes begin like a node packet, of any version and type.
[[nodiscard]] bool is_node_packet(std::span<const std::byte> bytes);

}  // namespace mien::imu
