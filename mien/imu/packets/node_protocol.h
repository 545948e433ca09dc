#pragma once

#include <map>

#include "mien/imu/packets/node_message.h"
#include "mien/imu/packets/seal.h"
#include "mien/sensor/protocol.h"

namespace mien::imu {

struct NodeProtocolSettings {
  std::string host_name = "mien";  ///< Shown by nodes; printable ASCII, at most kMaxNodeText.
  /// Random token of the session, not 0. Nodes with another session's token send a hello. Used in replies,
  /// and in the acceptance of sealed packets.
  std::uint64_t session = 1;
  /// Interval of the nodes' heartbeats, whole ms, 0.1 to 10 s. Raising: nodes without samples are noticed as
  /// lost later, less traffic. Lowering: sooner, more traffic.
  Duration heartbeat = std::chrono::milliseconds(500);
  /// With keys only packets sealed by one of them are accepted, each once, and replies are sealed with it.
  /// Empty: plain packets.
  std::vector<SealKey> keys;
};

/// Host side of the IMU nodes' protocol: samples (packet.h), hello and welcome, heartbeats, sync pulses
/// (node_message.h), and all of these sealed (seal.h). Replies to a hello with a welcome, to a heartbeat with
/// its echo. Inbox::opened receives the content of a sealed packet, so that a log replays without keys.
/// Layout: docs/reference/protocol.md.
class NodeProtocol final : public sensor::Protocol {
 public:
  /// Errors: bad_usage (settings outside their ranges, two keys of one id).
  [[nodiscard]] static Result<NodeProtocol> create(NodeProtocolSettings settings = {});

  [[nodiscard]] std::string_view name() const override { return "mien"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
  /// Nothing: nodes send first.
  void heartbeats(HostTime, std::vector<Outgoing>&) override {}

 private:
  explicit NodeProtocol(NodeProtocolSettings settings) : settings_(std::move(settings)) {}
  sensor::Verdict open(std::span<const std::byte> datagram, sensor::Inbox& inbox);
  sensor::Verdict take(std::span<const std::byte> packet, sensor::Inbox& inbox);
  sensor::Verdict take_samples(std::span<const std::byte> packet, sensor::Inbox& inbox);
  void reply(const NodeMessage& message, sensor::Inbox& inbox);

  NodeProtocolSettings settings_;
  std::map<std::uint64_t, ReplayWindow> windows_;  // By device; only of sealed packets.
  std::optional<SealHeader> seal_;                 // Of the packet in progress, if sealed.
  std::uint64_t sent_ = 0;                         // Sealed replies so far.
  std::vector<sensor::Sample> samples_;            // These three: buffers kept for their memory.
  ByteWriter plain_;
  ByteWriter sealed_;
};

}  // namespace mien::imu
