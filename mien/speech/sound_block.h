#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/sensor/sample.h"

namespace mien::speech {

/// Sound inside: one channel of 16-bit integers.
inline constexpr int kRateHz = 16'000;
/// A sample of this would be 1.
inline constexpr float kFullScale = 32'768;
/// Samples of a block: 20 ms.
inline constexpr std::size_t kBlockSamples = 320;
inline constexpr Duration kBlockDuration = std::chrono::milliseconds(20);
static_assert(kBlockDuration * kRateHz == std::chrono::seconds(kBlockSamples));
/// Frames of analysis in a block: 10 ms each.
inline constexpr std::size_t kFramesPerBlock = 2;
inline constexpr std::size_t kBlockBytes = 2 * kBlockSamples;

/// The samples of one block, -32,768 to 32,767.
using Block = std::array<std::int16_t, kBlockSamples>;

/// What stands beside a block's samples: a datagram, type 13. The samples themselves are its payload,
/// little-endian. Layout, byte by byte, with test vectors: docs/reference/protocol.md.
struct BlockHeader {
  std::uint64_t device = 0;  ///< Unique: a MAC in the low 48 bits.
  /// Counts blocks from the device's start, those that were lost too; below kMostBlocks.
  std::uint64_t block = 0;
  bool operator==(const BlockHeader&) const = default;

  /// Device time of the block's first sample: the count of samples before it, at kRateHz.
  [[nodiscard]] DeviceTime time() const;
};

/// Three years of blocks, as other device times go.
inline constexpr std::uint64_t kMostBlocks = 5'000'000'000;
inline constexpr std::size_t kHeaderBytes = 32;

/// Length of a packet of type 14: a header of the same fields, and the block's samples within it.
inline constexpr std::size_t kPacketBytes = kHeaderBytes + kBlockBytes;

/// Ids of devices (docs/reference/protocol.md): "02:4D:49:53:4E:00" is what is heard on this machine, which
/// nobody on a network can be; "02:4D:49:53:4E:01" a microphone that has no id of its own.
inline constexpr std::uint64_t kThisMachine = 0x024D'4953'4E00ULL;
inline constexpr std::uint64_t kAnyMicrophone = 0x024D'4953'4E01ULL;

/// Whether the bytes begin like a block's header; checks no more.
[[nodiscard]] bool is_block(std::span<const std::byte> bytes);
/// Whether they begin like a packet with a block in it; checks no more.
[[nodiscard]] bool is_packet(std::span<const std::byte> bytes);

/// Errors: truncated; malformed (magic, length, checksum, reserved bytes); unsupported (version, type);
/// out_of_range (count). No allocation but in errors. Thread-safe.
[[nodiscard]] Result<BlockHeader> parse_header(std::span<const std::byte> bytes);
/// Inverse of parse_header, to the byte. Errors: out_of_range.
[[nodiscard]] Result<std::vector<std::byte>> encode_header(const BlockHeader& header);

/// A block with its header, as a microphone on the network sends it.
struct Packet {
  BlockHeader header;
  /// The samples, kBlockBytes long: part of the bytes that were parsed.
  std::span<const std::byte> samples;
};
/// Errors: parse_header's, and out_of_range for a packet of this machine's own device. No allocation but in
/// errors. Thread-safe.
[[nodiscard]] Result<Packet> parse_packet(std::span<const std::byte> bytes);
/// Inverse of parse_packet, to the byte. Errors: out_of_range.
[[nodiscard]] Result<std::vector<std::byte>> encode_packet(const BlockHeader& header, const Block& block);

/// A block as a log has it: an entry's bytes are its header, with the samples as the entry's payload, or its
/// packet. None where they are neither.
struct LoggedBlock {
  BlockHeader header;
  Block block{};
};
[[nodiscard]] std::optional<LoggedBlock> logged_block(std::span<const std::byte> bytes,
                                                      std::span<const std::byte> payload);

/// The samples of a payload; none where it has another length.
[[nodiscard]] std::optional<Block> samples_of(std::span<const std::byte> payload);
/// The payload of so many samples.
[[nodiscard]] std::array<std::byte, kBlockBytes> payload_of(const Block& block);

/// What a block says in numbers: root mean square and peak, as shares of full scale, 0 to 1.
struct Loudness {
  float rms = 0;
  float peak = 0;
};
[[nodiscard]] Loudness loudness_of(const Block& block);

/// A sample of kind sound, but for its sensor: at the middle of the block.
[[nodiscard]] sensor::Sample sample_of(const BlockHeader& header, const Block& block);

}  // namespace mien::speech
