#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/error.h"
#include "mien/sensor/protocol.h"
#include "mien/sensor/seal.h"

namespace mien::sensor {

/// The languages of paired devices, in the one envelope that they share: opens sealed packets, and hands what
/// was in them to the language that it is of. What is not sealed is refused, and so is, of the sealed, what
/// is of no known key or was changed; a counter that came before; another session's token (but in a hello,
/// which asks for it); a packet inside that is of another device, of no such language or no packet of ours.
/// Inbox::opened receives the content, so that a log replays without keys. Replies are sealed with the key
/// that their packet came with. Layout: docs/reference/protocol.md.
class SealedProtocol final : public Protocol {
 public:
  /// `session` is the token that the languages' welcomes carry, random and not 0. The first of `languages`
  /// that recognises a packet gets it; of one that says something unasked (heartbeats()) this is not sent.
  /// Errors: bad_usage (no key, two of one id, token 0), internal (libsodium).
  [[nodiscard]] static Result<SealedProtocol> create(std::uint64_t session, std::vector<SealKey> keys,
                                                     std::vector<std::unique_ptr<Protocol>> languages);

  [[nodiscard]] std::string_view name() const override { return "sealed"; }
  /// Any packet of ours: those that are not sealed are refused, not malformed.
  [[nodiscard]] bool recognises(std::span<const std::byte> datagram) const override;
  Verdict receive(HostTime arrival, Peer peer, std::span<const std::byte> datagram, Inbox& inbox) override;

 private:
  SealedProtocol(std::uint64_t session, std::vector<SealKey> keys,
                 std::vector<std::unique_ptr<Protocol>> languages);
  /// Whether it may be what its header says; remembers its counter.
  [[nodiscard]] bool admit(const SealHeader& header, std::span<const std::byte> inner);
  void seal_reply(const SealHeader& to, Inbox& inbox);

  std::uint64_t session_;
  std::vector<SealKey> keys_;
  std::vector<std::unique_ptr<Protocol>> languages_;
  std::map<std::pair<std::uint8_t, std::uint64_t>, ReplayWindow> windows_;  // By key and device.
  std::uint64_t sent_ = 0;                                                  // Sealed replies so far.
  ByteWriter sealed_;                                                       // Kept for its memory.
};

}  // namespace mien::sensor
