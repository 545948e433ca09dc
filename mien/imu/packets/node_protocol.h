#pragma once

#include <map>

#include "mien/imu/packets/node_message.h"
#include "mien/imu/packets/seal.h"
#include "mien/sensor/protocol.h"

namespace mien::imu {

struct NodeProtocolSettings {
  std::string host_name = "mien";  ///< Shown by nodes; printable ASCII, at most kMaxNodeText.
  /// Drawn anew for every session; not 0. Nodes that know another session say hello again. It shows in
  /// replies alone, and in what keys let in.
  std::uint64_t session = 1;
  /// How often nodes are asked to send a heartbeat, 0.1 to 10 s. Raising notices lost nodes that send no
  /// samples later.
  Duration heartbeat = std::chrono::milliseconds(500);
  /// With keys only packets sealed by one of them are heard, each once, and replies are sealed alike.
  std::vector<SealKey> keys;
};

/// The host's side of our own nodes' language: samples (imu/packet.h), hello and welcome, heartbeats, pulses,
/// and all of these sealed. Hello is answered by welcome, a heartbeat by its echo. Where it opens a sealed
/// packet, Inbox::opened has what was inside; a log of that replays without keys.
class NodeProtocol final : public sensor::Protocol {
 public:
  /// Errors: bad_usage (settings outside their ranges, two keys of one id).
  [[nodiscard]] static Result<NodeProtocol> create(NodeProtocolSettings settings = {});

  [[nodiscard]] std::string_view name() const override { return "mien"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
  /// Nothing: nodes speak first.
  void heartbeats(HostTime, std::vector<Outgoing>&) override {}

 private:
  explicit NodeProtocol(NodeProtocolSettings settings) : settings_(std::move(settings)) {}
  sensor::Verdict open(std::span<const std::byte> datagram, sensor::Inbox& inbox);
  sensor::Verdict take(std::span<const std::byte> packet, sensor::Inbox& inbox);
  sensor::Verdict take_samples(std::span<const std::byte> packet, sensor::Inbox& inbox);
  void reply(const NodeMessage& message, sensor::Inbox& inbox);

  NodeProtocolSettings settings_;
  std::map<std::uint64_t, ReplayWindow> windows_;  // By device; only of those that had a key.
  std::optional<SealHeader> seal_;                 // Of the packet in hand, when it was sealed.
  std::uint64_t sent_ = 0;                         // Sealed replies.
  std::vector<sensor::Sample> samples_;            // These three for their memory.
  ByteWriter plain_;
  ByteWriter sealed_;
};

}  // namespace mien::imu
