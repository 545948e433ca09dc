#pragma once

#include <cstdint>
#include <deque>

#include "mien/virtual/network.h"
#include "mien/virtual/node.h"

namespace mien::virt {

/// One board of smart eyewear: it sends its scans, greets nobody and hears nothing.
class EyewearNode final : public Node {
 public:
  explicit EyewearNode(std::uint64_t device) : device_(device) {}
  /// A scan, heard at its time from the performance's time 0 on; in that order.
  void hand_over(Datagram scan) { scans_.push_back(std::move(scan)); }

  void begin(HostTime start) override { start_ = start; }
  [[nodiscard]] HostTime due() const override;
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override;
  void receive(HostTime, std::span<const std::byte>) override {}
  [[nodiscard]] std::uint64_t device() const override { return device_; }
  [[nodiscard]] bool listens() const override { return false; }
  [[nodiscard]] bool answered() const override { return false; }
  [[nodiscard]] bool idle() const override { return scans_.empty(); }

 private:
  std::uint64_t device_;
  std::optional<HostTime> start_;
  std::deque<Datagram> scans_;
};

}  // namespace mien::virt
