#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/rotation.h"
#include "mien/imu/packets/slimevr.h"
#include "mien/sensor/estimated_clock.h"
#include "mien/sensor/protocol.h"

namespace mien::imu {

/// Server side of the SlimeVR protocol (docs/reference/protocol.md). A board is identified by the MAC of its
/// handshake, at the peer that sent it: two peers may name one board, and whoever hears this tells them
/// apart. Peers without a handshake are ignored (they time out after 3 s and send one). Rotations become
/// imu_fused samples, each with the acceleration of its own datagram, else the newest of the last few; device
/// times are estimated, one clock a sensor. Packets whose number does not rise are ignored. Requests bundles,
/// but not their compact form, whose 16 bits are coarser than skin motion.
class SlimeVrProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "slimevr"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
  /// A heartbeat and a ping every 500 ms to each board received within 10 s.
  void heartbeats(HostTime now, std::vector<Outgoing>& out) override;

 private:
  struct Channel {
    std::uint8_t number = 0;
    std::optional<std::array<float, 4>> rotation;  // Of the current datagram, xyzw.
    std::array<float, 3> acceleration{};
    int acceleration_age = 0;  // Rotations since.
    sensor::EstimatedClock clock;
  };
  struct Board {
    sensor::Peer peer = 0;
    std::uint64_t mac = 0;
    std::uint32_t protocol = 0;
    std::string firmware;
    std::uint64_t last_number = 0;
    std::vector<Channel> channels;
    // For heartbeats(); receive() does not depend on these.
    HostTime received;
    HostTime next_heartbeat;
    std::vector<slimevr::SensorInfoAck> acks;
  };

  Board* board_of(sensor::Peer peer);
  Channel* channel_of(Board& board, std::uint8_t number, sensor::Inbox& inbox);
  sensor::Verdict greet(HostTime arrival, sensor::Peer peer, const slimevr::Handshake& handshake,
                        sensor::Inbox& inbox);
  void take(Board& board, const slimevr::TrackerMessage& message, sensor::Inbox& inbox);
  void finish(Board& board, HostTime arrival, std::uint64_t number, sensor::Inbox& inbox);
  void reply(const slimevr::ServerMessage& message, sensor::Inbox& inbox);

  std::vector<Board> boards_;
  std::uint32_t pings_ = 0;
  std::vector<slimevr::TrackerMessage> messages_;  // Buffer, kept for its memory.
  ByteWriter writer_;
};

}  // namespace mien::imu
