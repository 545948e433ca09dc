#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "mien/imu/fusion.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/virtual/imu/imu_node.h"

namespace mien::virt {

/// A SlimeVR tracker with one sensor, as its firmware behaves: a handshake every second until it is greeted,
/// then its sensor, its features, and 100 times a second the rotation that it has fused from the chip's raw
/// axes, with the acceleration without gravity. A rotation within 1e-4 of the last in every component is not
/// sent. Heartbeats and pings are answered; a server that has not been heard for 3 s is looked for anew.
/// Datagrams leave in their order (one radio has one queue), as bundles where the server understands them.
/// Its MAC is virtual_device()'s.
class SlimeVrNode : public ImuNode {
 public:
  SlimeVrNode(std::size_t sensor, const VirtualClock& clock);

  void begin(HostTime start) override { start_ = start; }
  [[nodiscard]] Result<void> play(std::span<const VirtualPacket> packets) override;
  [[nodiscard]] HostTime due() const override;
  [[nodiscard]] std::optional<std::vector<std::byte>> next_datagram(HostTime now) override;
  void receive(HostTime now, std::span<const std::byte> datagram) override;
  [[nodiscard]] std::uint64_t device() const override { return mac_; }
  [[nodiscard]] bool answered() const override { return greeted_; }
  [[nodiscard]] bool idle() const override { return turns_.empty() && pending_.empty(); }

 private:
  /// What the board knows of one moment.
  struct Turn {
    Duration arrival{};  // From the performance's time 0.
    bool lost = false;
    std::array<float, 4> xyzw{};
    std::array<float, 3> m_s2{};
  };
  void fuse(const sensor::Sample& sample, const VirtualPacket& packet);
  [[nodiscard]] Turn turn_at(DeviceTime mark) const;
  void put(HostTime due, const imu::slimevr::TrackerMessage& message);
  void put_turn(HostTime due, const Turn& turn);
  void greet(HostTime now);

  std::uint64_t mac_;
  VirtualClock clock_;

  // The chip's side.
  imu::Fusion fusion_;
  struct Fused {
    DeviceTime time;
    Quat q_world_sensor;
    Vec3 force_m_s2;
  };
  std::optional<Fused> before_;
  Fused latest_;
  DeviceTime next_mark_;
  std::deque<Turn> turns_;

  // The network's side.
  std::optional<HostTime> start_;
  std::deque<std::pair<HostTime, std::vector<std::byte>>> pending_;
  std::uint64_t number_ = 0;
  bool greeted_ = false;
  HostTime received_;
  HostTime next_handshake_;
  std::optional<HostTime> next_info_;   // None: acknowledged.
  std::optional<HostTime> next_flags_;  // None: answered, or asked often enough.
  int flags_asked_ = 0;
  HostTime next_battery_;
  bool bundles_ = false;
  std::optional<std::array<float, 4>> last_sent_;
};

}  // namespace mien::virt
