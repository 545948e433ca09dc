#include "mien/speech/sound_block.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "mien/core/bytes.h"
#include "mien/sensor/packet_envelope.h"

namespace mien::speech {
namespace {

constexpr std::uint8_t kTypeHeader = 13;
constexpr std::uint8_t kTypePacket = 14;
const char* const kSoundBlock = "sound block";

/// What both begin with, to where the samples may stand. Errors: as parse_header() has them.
Result<BlockHeader> parse_begin(std::span<const std::byte> bytes, std::uint8_t type, std::size_t length) {
  MIEN_TRY(sensor::check_length(bytes.size(), length, kSoundBlock));
  ByteReader reader(bytes);
  MIEN_TRY(sensor::read_packet_begin(reader, type, "no such sound", kSoundBlock));
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

Result<std::vector<std::byte>> encode(std::uint8_t type, const BlockHeader& header,
                                      std::span<const std::byte> samples) {
  if (header.block >= kMostBlocks)
    return fail(ErrorCode::out_of_range, "a block of more than three years", kSoundBlock);
  ByteWriter writer;
  sensor::write_packet_begin(type, writer);
  writer.little(std::uint16_t{0});
  writer.little(header.device);
  writer.little(header.block);
  writer.little(std::uint32_t{0});
  writer.append(samples);
  sensor::write_checksum(0, writer);
  return writer.release();
}

}  // namespace

DeviceTime BlockHeader::time() const {
  return DeviceTime(kBlockDuration * static_cast<std::int64_t>(block));
}

bool is_block(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypeHeader);
}

bool is_packet(std::span<const std::byte> bytes) {
  return sensor::is_our_packet(bytes, kTypePacket);
}

Result<BlockHeader> parse_header(std::span<const std::byte> bytes) {
  return parse_begin(bytes, kTypeHeader, kHeaderBytes);
}

Result<std::vector<std::byte>> encode_header(const BlockHeader& header) {
  return encode(kTypeHeader, header, {});
}

Result<Packet> parse_packet(std::span<const std::byte> bytes) {
  MIEN_TRY_ASSIGN(const BlockHeader header, parse_begin(bytes, kTypePacket, kPacketBytes));
  if (header.device == kThisMachine)
    return fail(ErrorCode::out_of_range, "nobody on a network is this machine's own microphone", kSoundBlock);
  return Packet{header, bytes.subspan(kHeaderBytes - sensor::kChecksumBytes, kBlockBytes)};
}

Result<std::vector<std::byte>> encode_packet(const BlockHeader& header, const Block& block) {
  return encode(kTypePacket, header, payload_of(block));
}

std::optional<LoggedBlock> logged_block(std::span<const std::byte> bytes,
                                        std::span<const std::byte> payload) {
  BlockHeader header;
  if (is_packet(bytes)) {
    const auto packet = parse_packet(bytes);
    if (!packet) return std::nullopt;
    header = packet->header;
    payload = packet->samples;
  } else {
    const auto parsed = parse_header(bytes);
    if (!parsed) return std::nullopt;
    header = *parsed;
  }
  const auto block = samples_of(payload);
  if (!block) return std::nullopt;
  return LoggedBlock{header, *block};
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
