#pragma once

#include <cstdint>
#include <deque>
#include <utility>

#include "mien/virtual/network.h"
#include "mien/virtual/node.h"

namespace mien::virt {

/// A board of smart eyewear, a microphone or a phone: it sends what it measures, greets nobody and hears
/// nothing.
class SpeakingNode final : public Node {
 public:
  explicit SpeakingNode(std::uint64_t device) : device_(device) {}
  /// A packet, which arrives at its time from the performance's time 0 on; in that order.
  void hand_over(Datagram packet) { packets_.push_back(std::move(packet)); }

  void begin(HostTime start) override { start_ = start; }
  [[nodiscard]] HostTime due() const override;
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override;
  void receive(HostTime, std::span<const std::byte>) override {}
  [[nodiscard]] std::uint64_t device() const override { return device_; }
  [[nodiscard]] bool listens() const override { return false; }
  [[nodiscard]] bool answered() const override { return false; }
  [[nodiscard]] bool idle() const override { return packets_.empty(); }

 private:
  std::uint64_t device_;
  std::optional<HostTime> start_;
  std::deque<Datagram> packets_;
};

}  // namespace mien::virt
