#include "mien/speech/sound_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "mien/core/bytes.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::speech {
namespace {

constexpr std::uint8_t kTypeSound = 13;
const char* const kSoundBlock = "sound block";

}  // namespace

DeviceTime BlockHeader::time() const {
  return DeviceTime(kBlockDuration * static_cast<std::int64_t>(block));
}

bool is_block(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypeSound);
}

Result<BlockHeader> parse_header(std::span<const std::byte> bytes) {
  MIEN_TRY(sensor::check_length(bytes.size(), kHeaderBytes, kSoundBlock));
  ByteReader reader(bytes);
  MIEN_TRY_ASSIGN(const std::uint8_t type, sensor::read_packet_begin(reader, kSoundBlock));
  if (type != kTypeSound)
    return fail(ErrorCode::unsupported, fmt::format("packet type {} is no sound", type), kSoundBlock);
  MIEN_TRY(sensor::check_checksum(bytes, kSoundBlock));
  BlockHeader header;
  bool reserved = reader.little<std::uint16_t>() != 0;
  header.device = reader.little<std::uint64_t>();
  header.block = reader.little<std::uint64_t>();
  reserved = reader.little<std::uint32_t>() != 0 || reserved;
  if (reserved) return fail(ErrorCode::malformed, "a reserved byte is set", kSoundBlock);
  if (header.block >= kMostBlocks)
    return fail(ErrorCode::out_of_range, "a block of more than three years", kSoundBlock);
  return header;
}

Result<std::vector<std::byte>> encode_header(const BlockHeader& header) {
  if (header.block >= kMostBlocks)
    return fail(ErrorCode::out_of_range, "a block of more than three years", kSoundBlock);
  ByteWriter writer;
  sensor::write_packet_begin(kTypeSound, writer);
  writer.little(std::uint16_t{0});
  writer.little(header.device);
  writer.little(header.block);
  writer.little(std::uint32_t{0});
  sensor::write_checksum(0, writer);
  return writer.release();
}

std::optional<Block> samples_of(std::span<const std::byte> payload) {
  if (payload.size() != kBlockBytes) return std::nullopt;
  Block block;
  ByteReader reader(payload);
  for (std::int16_t& sample : block) sample = reader.little<std::int16_t>();
  return block;
}

std::array<std::byte, kBlockBytes> payload_of(const Block& block) {
  std::array<std::byte, kBlockBytes> out{};
  for (std::size_t i = 0; i < block.size(); ++i) {
    const auto bits = static_cast<std::uint16_t>(block[i]);
    out[2 * i] = static_cast<std::byte>(bits & 0xFFU);
    out[2 * i + 1] = static_cast<std::byte>(bits >> 8U);
  }
  return out;
}

Loudness loudness_of(const Block& block) {
  double square = 0;
  int peak = 0;
  for (const std::int16_t sample : block) {
    square += static_cast<double>(sample) * sample;
    peak = std::max(peak, std::abs(int{sample}));
  }
  return {static_cast<float>(std::sqrt(square / kBlockSamples) / kFullScale),
          static_cast<float>(peak) / kFullScale};
}

sensor::Sample sample_of(const BlockHeader& header, const Block& block) {
  sensor::Sample sample;
  sample.kind = sensor::SampleKind::sound;
  sample.sequence = static_cast<std::uint32_t>(header.block);
  sample.time = header.time() + kBlockDuration / 2;
  const Loudness loudness = loudness_of(block);
  sample.count = 2;
  sample.values[0] = loudness.rms;
  sample.values[1] = loudness.peak;
  return sample;
}

}  // namespace mien::speech
