#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/imu/packets/node_message.h"
#include "mien/sensor/protocol.h"

namespace mien::imu {

struct NodeProtocolSettings {
  std::string host_name = "mien";  ///< Shown by nodes; printable ASCII, at most kMaxNodeText.
  /// Random token of the session, not 0, sent in replies. Nodes with another session's token send a hello.
  std::uint64_t session = 1;
  /// Interval of the nodes' heartbeats, whole ms, 0.1 to 10 s. Raising: nodes without samples are noticed as
  /// lost later, less traffic. Lowering: sooner, more traffic.
  Duration heartbeat = std::chrono::milliseconds(500);
};

/// Host side of the IMU nodes' protocol: samples (packet.h), hello and welcome, heartbeats, sync pulses
/// (node_message.h). Replies to a hello with a welcome, to a heartbeat with its echo. Refuses sealed packets:
/// those of paired nodes reach it opened (sensor::SealedProtocol). Layout: docs/reference/protocol.md.
class NodeProtocol final : public sensor::Protocol {
 public:
  /// Errors: bad_usage (settings outside their ranges).
  [[nodiscard]] static Result<NodeProtocol> create(NodeProtocolSettings settings = {});

  [[nodiscard]] std::string_view name() const override { return "mien"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;

 private:
  explicit NodeProtocol(NodeProtocolSettings settings) : settings_(std::move(settings)) {}
  sensor::Verdict take_samples(std::span<const std::byte> packet, sensor::Inbox& inbox);
  void reply(const NodeMessage& message, sensor::Inbox& inbox);

  NodeProtocolSettings settings_;
  std::vector<sensor::Sample> samples_;  // These two: buffers kept for their memory.
  ByteWriter reply_;
};

}  // namespace mien::imu
