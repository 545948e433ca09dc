#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mien/sensor/seal.h"
#include "mien/virtual/node.h"
#include "mien/virtual/node_greeting.h"

namespace mien::virt {

/// A board of ours that was paired: what the node in it says leaves sealed (docs/reference/protocol.md), and
/// of what arrives it hears what its host sealed, each once. For a node that only speaks, such as glasses, it
/// says hello and heartbeats itself, since packets need the session's token.
class SealedNode final : public Node {
 public:
  /// `node` speaks our own packets, and outlives this. `power_ons`: times that the board was switched on,
  /// below 2^31; a host refuses what is not after the last time, and no two may be the same under one key.
  SealedNode(Node& node, const sensor::SealKey& key, std::uint32_t power_ons = 1);

  void begin(HostTime start) override;
  [[nodiscard]] HostTime due() const override;
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override;
  void receive(HostTime now, std::span<const std::byte> datagram) override;
  [[nodiscard]] std::uint64_t device() const override { return node_.device(); }
  [[nodiscard]] bool listens() const override { return true; }
  [[nodiscard]] bool answered() const override {
    return greeting_ ? greeting_->answered() : node_.answered();
  }
  [[nodiscard]] bool idle() const override { return node_.idle(); }

 private:
  [[nodiscard]] std::optional<std::vector<std::byte>> next_inner(HostTime now);

  Node& node_;
  sensor::SealKey key_;
  std::optional<NodeGreeting> greeting_;  // Of a node that only speaks.
  HostTime start_;
  std::uint64_t counter_;      // Bits 32 to 62: times that it was switched on.
  std::uint64_t session_ = 0;  // The host's token; 0 before its welcome.
  sensor::ReplayWindow host_;
  std::vector<std::byte> opened_;
};

}  // namespace mien::virt
