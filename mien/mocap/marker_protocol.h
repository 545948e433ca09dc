#pragma once

#include <string_view>

#include "mien/sensor/protocol.h"

namespace mien::mocap {

/// Host side of a motion capture server that sends markers (mocap/marker_packet.h). Markers are ground truth:
/// well-formed packets are kept in the session's log, with their arrival, and give no samples, so that no
/// marker influences a weight. `mien import` of the take decodes them.
class MarkerProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "markers"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
};

}  // namespace mien::mocap
