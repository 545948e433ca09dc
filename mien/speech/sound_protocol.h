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

/// Host side of microphones on the network: packets of type 14 (speech/sound_block.h), each a block of 20 ms.
/// Each becomes one sample of SampleKind::sound, whose payload is that part of the packet. Packets of this
/// machine's own device are malformed: SoundProtocol hears that.
class MicrophoneProtocol final : public sensor::Protocol {
 public:
  [[nodiscard]] std::string_view name() const override { return "microphone"; }
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  sensor::Verdict receive(HostTime arrival, sensor::Peer peer, std::span<const std::byte> datagram,
                          sensor::Inbox& inbox) override;
};

}  // namespace mien::speech
