#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mien/core/time.h"
#include "mien/imu/packets/node_message.h"

namespace mien::virt {

/// What a board that speaks our own packets says besides its samples: a hello every second until it is
/// welcomed, heartbeats from the performance's begin on once it is. A host that has not been heard for
/// kReceiverGone is looked for anew, and so is one that echoes another session's token.
class NodeGreeting {
 public:
  explicit NodeGreeting(imu::Hello hello) : hello_(std::move(hello)) {}

  [[nodiscard]] std::uint64_t device() const { return hello_.device; }
  void begin(HostTime start) { start_ = start; }
  [[nodiscard]] HostTime due() const;
  /// A hello that is due now.
  [[nodiscard]] std::optional<std::vector<std::byte>> next_hello(HostTime now);
  /// Whether a heartbeat is due now; one is to be sent then.
  [[nodiscard]] bool heartbeat_due(HostTime now);
  /// The heartbeat with this charge (0 to 100 or sensor::kBatteryUnknown) at this time of the node's clock,
  /// which shows no less than zero and whole microseconds.
  [[nodiscard]] std::vector<std::byte> heartbeat(std::uint8_t battery_percent, DeviceTime time) const;
  void receive(HostTime now, std::span<const std::byte> datagram);
  [[nodiscard]] bool answered() const { return welcome_.has_value(); }

 private:
  imu::Hello hello_;
  std::optional<HostTime> start_;
  std::optional<imu::Welcome> welcome_;
  HostTime received_;                                // The host's latest word.
  std::optional<HostTime> next_hello_ = HostTime();  // None while welcomed.
  HostTime next_heartbeat_;
};

}  // namespace mien::virt
