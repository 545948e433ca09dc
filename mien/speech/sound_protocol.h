#pragma once

#include "mien/sensor/protocol.h"

namespace mien::speech {

/// Host side of sound: blocks of 20 ms (speech/sound_block.h) of this machine's microphones and files. Each
/// becomes one sample of SampleKind::sound with the block as its payload. A header without a block's payload
/// is malformed.
class SoundProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "sound"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive_with_payload(HostTime arrival, sensor::Peer peer,
                                       std::span<const std::byte> datagram,
                                       std::span<const std::byte> payload, sensor::Inbox& inbox) override;
};

}  // namespace mien::speech
