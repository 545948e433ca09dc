#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/error.h"

namespace mien::sensor {

/// A key shared by a node and its host, provisioned out of band. Its holder can impersonate both.
struct SealKey {
  std::uint8_t id = 0;  ///< Number of the key, sent in the packet.
  std::array<std::byte, 32> secret{};
};

/// Packet types of our own that sealing knows: the sealed packet itself, and the one which may be sealed
/// before its device knows the session's token.
inline constexpr std::uint8_t kSealedPacketType = 7;
inline constexpr std::uint8_t kHelloPacketType = 2;

/// Plain header of a sealed packet. The triple (device, counter, session) is the cipher's nonce and must
/// never repeat under one key.
struct SealHeader {
  /// Set in the counters of packets from the host, never in a node's.
  static constexpr std::uint64_t kFromHost = std::uint64_t{1} << 63U;

  std::uint8_t key_id = 0;
  std::uint64_t device = 0;  ///< The sending or addressed node.
  /// Rises with every packet. A node's persists over power-off: bits 32 to 62 count its power-ons (in flash),
  /// bits 0 to 31 the packets since.
  std::uint64_t counter = 0;
  std::uint64_t session = 0;  ///< The session's token; 0 in a hello.
  bool operator==(const SealHeader&) const = default;
};

inline constexpr std::size_t kMaxSealedInner = 1024;  ///< Most bytes of the inner packet.

/// Appends `inner`, a complete packet of ours, to `out`, encrypted and authenticated (XChaCha20-Poly1305,
/// libsodium). Layout: docs/reference/protocol.md. Errors: bad_usage (another key's id, an inner packet that
/// is empty, too long or sealed). Thread-safe.
[[nodiscard]] Result<void> seal_packet(const SealKey& key, const SealHeader& header,
                                       std::span<const std::byte> inner, ByteWriter& out);

/// Whether the bytes begin like a sealed packet.
[[nodiscard]] bool is_sealed(std::span<const std::byte> bytes);

/// Decrypts a sealed packet with the key of `keys` that it names into `inner`, which is empty on errors. Does
/// not detect replays (ReplayWindow). Errors: truncated; malformed (magic, length, checksum, reserved byte);
/// unsupported (version, type); mismatch (no such key, or authentication failed). No allocation but in errors
/// and when `inner` grows. Thread-safe.
[[nodiscard]] Result<SealHeader> open_sealed(std::span<const SealKey> keys, std::span<const std::byte> bytes,
                                             std::vector<std::byte>& inner);

/// Sliding-window replay protection for one sender: accepts each counter once, and counters late by less than
/// kWidth. A value type.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kWidth = 64;
  /// True, once, for a counter not accepted before and not too old.
  [[nodiscard]] bool accept(std::uint64_t counter);

 private:
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // Bit i: newest_ - i was accepted. 0: none yet.
};

}  // namespace mien::sensor
