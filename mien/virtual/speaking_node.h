#pragma once

#include <cstdint>
#include <deque>
#include <utility>

#include "mien/virtual/network.h"
#include "mien/virtual/node.h"
#include "mien/virtual/worn_devices.h"

namespace mien::virt {

/// A board of smart eyewear, a microphone or a phone: it sends what it measures, greets nobody and hears
/// nothing.
class SpeakingNode final : public Node {
 public:
  explicit SpeakingNode(std::uint64_t device) : device_(device) {}
  /// A packet, which arrives at its time from the performance's time 0 on; in that order.
  void hand_over(Datagram packet) { packets_.push_back(std::move(packet)); }

  void begin(HostTime start) override { start_ = start; }
  [[nodiscard]] HostTime due() const override {
    if (!start_ || packets_.empty()) return HostTime::max();
    return *start_ + packets_.front().time.time_since_epoch();
  }
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override {
    if (now < due()) return std::nullopt;
    std::vector<std::byte> bytes = std::move(packets_.front().bytes);
    packets_.pop_front();
    return bytes;
  }
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

/// Devices whose boards only speak.
class SpeakingDevices : public NodeDevices {
 public:
  [[nodiscard]] std::vector<Node*> nodes() override {
    std::vector<Node*> all;
    for (SpeakingNode& node : nodes_) all.push_back(&node);
    return all;
  }
  [[nodiscard]] double simulated_s() const override { return simulated_s_; }
  [[nodiscard]] bool done() const override { return !motion_.encore && simulated_s_ >= end_s_; }

 protected:
  /// Without an encore they are done at `end_s`, true time.
  SpeakingDevices(const PlayedMotion& motion, double end_s) : motion_(motion), end_s_(end_s) {}

  PlayedMotion motion_;
  std::vector<SpeakingNode> nodes_;
  double simulated_s_ = -kDeviceMarginS;

 private:
  double end_s_;
};

}  // namespace mien::virt
