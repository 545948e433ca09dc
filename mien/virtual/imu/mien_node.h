#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/imu_node.h"
#include "mien/virtual/node_greeting.h"

namespace mien::virt {

/// A node that speaks our own packets (docs/reference/protocol.md): hello with its site every second until it
/// is welcomed, samples when the simulated radio would deliver them whether it is welcomed or not, heartbeats
/// once it is. The samples' bytes are those that a take of the same performance holds.
class MienNode : public ImuNode {
 public:
  /// `sensor` is its place in the rig and gives it its id, `site` the rig's name for it.
  MienNode(std::size_t sensor, std::string site, const VirtualClock& clock, const DeviceFaults& faults);

  void begin(HostTime start) override;
  [[nodiscard]] Result<void> play(std::span<const VirtualPacket> packets) override;
  [[nodiscard]] HostTime due() const override;
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override;
  void receive(HostTime now, std::span<const std::byte> datagram) override {
    greeting_.receive(now, datagram);
  }
  [[nodiscard]] std::uint64_t device() const override { return greeting_.device(); }
  [[nodiscard]] bool answered() const override { return greeting_.answered(); }
  [[nodiscard]] bool idle() const override { return samples_.empty(); }

 private:
  NodeGreeting greeting_;
  VirtualClock clock_;
  DeviceFaults faults_;
  std::optional<HostTime> start_;
  std::multimap<Duration, std::vector<std::byte>> samples_;  // By arrival, from the performance's time 0.
};

}  // namespace mien::virt
