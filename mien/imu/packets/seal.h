#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/core/error.h"

namespace mien::imu {

/// A key that a node and its host were given once, out of band. Whoever has it can speak for both.
struct SealKey {
  std::uint8_t id = 0;  ///< Which of the host's keys; stands in the packet.
  std::array<std::byte, 32> secret{};
};

/// What stands in the open on a sealed packet. The triple (device, counter, session) never comes twice under
/// one key: it is the cipher's nonce.
struct SealHeader {
  /// Set in the counters of packets from the host, never in a node's.
  static constexpr std::uint64_t kFromHost = std::uint64_t{1} << 63U;

  std::uint8_t key_id = 0;
  std::uint64_t device = 0;  ///< The node that speaks or is spoken to.
  /// Rises with every packet. A node's survives its power-off: bits 32 to 62 count its power-ons, kept in its
  /// flash, bits 0 to 31 the packets since.
  std::uint64_t counter = 0;
  std::uint64_t session = 0;  ///< The token of the session that is meant; 0 in a hello, which knows none.
  bool operator==(const SealHeader&) const = default;
};

inline constexpr std::size_t kMaxSealedInner = 1024;  ///< Bytes of the packet inside.

/// Appends `inner`, a whole packet of ours, to `out` encrypted and authenticated (XChaCha20-Poly1305 by
/// libsodium). Layout: docs/reference/protocol.md. Errors: bad_usage (another key's id, an inner packet that
/// is empty, too long or sealed). Thread-safe.
[[nodiscard]] Result<void> seal_packet(const SealKey& key, const SealHeader& header,
                                       std::span<const std::byte> inner, ByteWriter& out);

/// True when the bytes begin as a sealed packet does.
[[nodiscard]] bool is_sealed(std::span<const std::byte> bytes);

/// Opens a sealed packet with the key of `keys` that it names, into `inner`, which is empty on errors.
/// Replays are for ReplayWindow to find. Errors: truncated; malformed (magic, length, checksum, reserved
/// byte); unsupported (version, type); mismatch (no such key, or the packet was not sealed with it as it
/// stands). No allocation but in errors and when `inner` grows. Thread-safe.
[[nodiscard]] Result<SealHeader> open_sealed(std::span<const SealKey> keys, std::span<const std::byte> bytes,
                                             std::vector<std::byte>& inner);

/// Lets each of one sender's counters in once: a packet may be late by less than 64 of them. A value type.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kWidth = 64;
  /// True for a counter that is new and not too old, which is thereby used up.
  [[nodiscard]] bool accept(std::uint64_t counter);

 private:
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // Bit i: newest_ - i was let in. 0: nothing yet.
};

}  // namespace mien::imu
