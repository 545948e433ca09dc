#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mien/imu/packets/seal.h"
#include "mien/virtual/node.h"

namespace mien::virt {

/// A board of ours that was paired: what the node in it says leaves sealed (docs/reference/protocol.md), and
/// of what arrives it hears what its host sealed, each once. It was switched on for the first time.
class SealedNode final : public Node {
 public:
  /// `node` speaks our own packets, and outlives this.
  SealedNode(Node& node, const imu::SealKey& key) : node_(node), key_(key) {}

  void begin(HostTime start) override { node_.begin(start); }
  [[nodiscard]] HostTime due() const override { return node_.due(); }
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override;
  void receive(HostTime now, std::span<const std::byte> datagram) override;
  [[nodiscard]] bool listens() const override { return node_.listens(); }
  [[nodiscard]] bool answered() const override { return node_.answered(); }
  [[nodiscard]] bool idle() const override { return node_.idle(); }

 private:
  Node& node_;
  imu::SealKey key_;
  std::uint64_t device_ = 0;                         // The node's, once it has said something.
  std::uint64_t counter_ = std::uint64_t{1} << 32U;  // Bits 32 to 62: times that it was switched on.
  std::uint64_t session_ = 0;                        // The host's token; 0 before its welcome.
  imu::ReplayWindow host_;
  std::vector<std::byte> opened_;
};

}  // namespace mien::virt
