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

/// Where a host listens for our nodes, and where a node that knows no host broadcasts its hello (UDP).
inline constexpr std::uint16_t kNodePort = 5005;
/// A node that was not welcomed says hello again after this time.
inline constexpr Duration kHelloPeriod = std::chrono::seconds(1);

inline constexpr std::size_t kMaxNodeChannels = 16;
inline constexpr std::size_t kMaxNodeText = 64;  ///< Bytes of a site, a firmware, a host's name.

/// What our nodes and their host say to each other beside samples, version 1. Layout, byte by byte, with test
/// vectors: docs/reference/protocol.md. All texts are printable ASCII of at most kMaxNodeText characters.
///
/// Node to everybody, or to the host it was told of: here I am.
struct Hello {
  std::uint64_t device = 0;
  double rate_hz = 240;  ///< Samples a second of each channel, 1 to 10,000; the wire has thousandths.
  std::string firmware;  ///< For people; may be empty.
  std::vector<std::string> sites;  ///< One a channel, from channel 0: the rig's name of its site, or empty. 1
                                   ///< to kMaxNodeChannels.
  bool operator==(const Hello&) const = default;
};

/// Host to node, the answer to hello: send me your samples.
struct Welcome {
  std::uint64_t device = 0;  ///< The node that is meant.
  std::uint64_t session =
      0;  ///< Drawn at the session's start, never 0: a node that sees another one says hello.
  Duration heartbeat =
      std::chrono::milliseconds(500);  ///< How often the node shall; whole ms, 100 to 10,000.
  std::string host;                    ///< For people; may be empty.
  bool operator==(const Welcome&) const = default;
};

/// Node to host: still here.
struct NodeHeartbeat {
  std::uint64_t device = 0;
  std::uint8_t battery_percent = 255;  ///< 0 to 100, or kBatteryUnknown.
  DeviceTime time;                     ///< Now, by the node's clock; whole microseconds.
  bool operator==(const NodeHeartbeat&) const = default;
};

/// Host to node, the answer to a heartbeat: the node's own time again, so that it sees its round trip.
struct HeartbeatEcho {
  std::uint64_t device = 0;
  DeviceTime time;  ///< As the heartbeat had it.
  std::uint64_t session = 0;
  bool operator==(const HeartbeatEcho&) const = default;
};

/// Node to host: a pulse came over the wire that all nodes share. The same moment on every node's own clock,
/// however late the radio tells of it.
struct Pulse {
  std::uint64_t device = 0;
  std::uint32_t index = 0;  ///< Counts the pulses; the same on every node.
  DeviceTime edge;          ///< When the edge was felt; whole microseconds.
  bool operator==(const Pulse&) const = default;
};

using NodeMessage = std::variant<Hello, Welcome, NodeHeartbeat, HeartbeatEcho, Pulse>;

/// The sixth byte of our packets.
enum class NodePacketType : std::uint8_t {
  samples = 1,  ///< imu/packet.h
  hello = 2,
  welcome = 3,
  heartbeat = 4,
  echo = 5,
  pulse = 6,
  sealed = 7,  ///< imu/seal.h
};

/// Any packet of ours but samples and sealed ones. Errors: truncated; malformed (magic, length, checksum,
/// reserved bytes, text); unsupported (version, type); out_of_range (channels, rate, battery, time, period).
/// Thread-safe.
[[nodiscard]] Result<NodeMessage> parse_node_message(std::span<const std::byte> bytes);

/// Appends the datagram to `out`. What was parsed goes back to the same bytes. Errors: those that the parser
/// would find; then `out` is as it was. No allocation when `out` has room.
[[nodiscard]] Result<void> encode_node_message(const NodeMessage& message, ByteWriter& out);

/// True when the bytes begin as packets of ours do, of whatever version and type.
[[nodiscard]] bool is_node_packet(std::span<const std::byte> bytes);

}  // namespace mien::imu
