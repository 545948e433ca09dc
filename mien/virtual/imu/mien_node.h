#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "mien/imu/packets/node_message.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/imu/imu_node.h"

namespace mien::virt {

/// A node that speaks our own packets (docs/reference/protocol.md): hello with its site every second until it
/// is welcomed, samples when the simulated radio would deliver them whether it is welcomed or not, heartbeats
/// once it is. The samples' bytes are those that a take of the same performance holds.
class MienNode : public ImuNode {
 public:
  /// `sensor` is its place in the rig and gives it its id, `site` the rig's name for it.
  MienNode(std::size_t sensor, std::string site, const VirtualClock& clock, const DeviceFaults& faults);

  void begin(HostTime start) override { start_ = start; }
  [[nodiscard]] Result<void> play(std::span<const VirtualPacket> packets) override;
  [[nodiscard]] HostTime due() const override;
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override;
  void receive(HostTime now, std::span<const std::byte> datagram) override;
  [[nodiscard]] bool answered() const override { return welcome_.has_value(); }
  [[nodiscard]] bool idle() const override { return samples_.empty(); }

 private:
  [[nodiscard]] std::vector<std::byte> encoded(const imu::NodeMessage& message) const;

  imu::Hello hello_;
  VirtualClock clock_;
  DeviceFaults faults_;
  std::optional<HostTime> start_;
  std::multimap<Duration, std::vector<std::byte>> samples_;  // By arrival, from the performance's time 0.
  std::optional<imu::Welcome> welcome_;
  HostTime received_;                                // The host's latest word.
  std::optional<HostTime> next_hello_ = HostTime();  // None while welcomed.
  HostTime next_heartbeat_;
};

}  // namespace mien::virt
