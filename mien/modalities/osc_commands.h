#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "mien/sensor/protocol.h"

namespace mien::modalities {

/// Commands of the session by OSC, from whoever cannot reach the page or a keyboard: a headset's controller,
/// an avatar's menu. Addresses: /mien/recentre, and /avatar/parameters/mien/recentre as VRChat sends an
/// avatar's parameters. Arguments: none, or one that says whether the button is pressed: T, F, or a number,
/// pressed where it is not 0. docs/reference/osc_commands.md. OSC has neither keys nor devices: a session
/// with keys does not hear it.
class OscCommands final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "OSC commands"; }
  /// Whether the first message has one of the addresses.
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  /// Ignored: a button that is released. Malformed: read_osc()'s errors; other arguments than those.
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
};

}  // namespace mien::modalities
