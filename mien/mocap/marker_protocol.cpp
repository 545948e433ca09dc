#include "mien/mocap/marker_protocol.h"

#include "mien/mocap/marker_packet.h"

namespace mien::mocap {

bool MarkerProtocol::recognises(std::span<const std::byte> datagram) const {
  return is_marker_packet(datagram);
}

sensor::Verdict MarkerProtocol::receive(HostTime, sensor::Peer, std::span<const std::byte> datagram,
                                        sensor::Inbox&) {
  const auto packet = parse_marker_packet(datagram);
  // Packets of newer versions are kept in the log, for newer programs.
  const bool kept = packet || packet.error().code == ErrorCode::unsupported;
  return kept ? sensor::Verdict::ignored : sensor::Verdict::malformed;
}

}  // namespace mien::mocap
