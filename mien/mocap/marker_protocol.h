#pragma once

#include <string_view>
#include <vector>

#include "mien/sensor/protocol.h"

namespace mien::mocap {

/// The host's side of a motion capture server that sends markers (eyewear/marker_packet.h). They are truth:
/// what is well formed is ignored, which leaves it in the session's log with its arrival, its own device
/// times inside, and gives readings to nobody. Hence no marker moves a weight. `mien import` of the take
/// decodes them.
class MarkerProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "markers"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
  /// Nothing: servers are not spoken to.
  void heartbeats(HostTime, std::vector<Outgoing>&) override {}
};

}  // namespace mien::mocap
