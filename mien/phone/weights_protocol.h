#pragma once

#include "mien/sensor/protocol.h"

namespace mien::phone {

/// Host side of other programs' weights: our packet (phone/packet.h). The samples of one packet share
/// sequence number and time (phone/told_face.h); one in which nothing is told says that its sender is alive,
/// one whose origin is held that it sees no face.
class WeightsProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "weights"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  /// Another version's packet is ignored.
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
};

}  // namespace mien::phone
