// Blocks of sound that a microphone on the network sends.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mien/core/bytes.h"
#include "mien/speech/sound_block.h"
#include "mien/speech/sound_protocol.h"

namespace mien::speech::microphone_protocol_test {
namespace {

using sensor::Verdict;

const BlockHeader kHeader = {.device = kAnyMicrophone, .block = 1'000};

Block ramp() {
  Block block;
  for (std::size_t i = 0; i < block.size(); ++i)
    block[i] = static_cast<std::int16_t>(100 * static_cast<int>(i) - 16'000);
  return block;
}

/// With the checksum that belongs to it.
std::vector<std::byte> summed(std::vector<std::byte> packet) {
  const std::uint32_t sum = crc32(std::span(packet).first(packet.size() - 4));
  for (std::size_t i = 0; i < 4; ++i)
    packet[packet.size() - 4 + i] = static_cast<std::byte>((sum >> (8 * i)) & 0xFFU);
  return packet;
}

TEST(MicrophonePacket, HasTheLayoutOfTheProtocolPage) {
  const std::vector<std::byte> packet = encode_packet(kHeader, ramp()).value();
  ASSERT_EQ(packet.size(), kPacketBytes);
  EXPECT_EQ(kPacketBytes, 672U);
  std::vector<std::byte> expected = encode_header(kHeader).value();
  expected[5] = std::byte{14};
  expected.resize(28);
  const auto samples = payload_of(ramp());
  expected.insert(expected.end(), samples.begin(), samples.end());
  expected.resize(expected.size() + 4);
  EXPECT_EQ(packet, summed(expected));
  const Packet parsed = parse_packet(packet).value();
  EXPECT_EQ(parsed.header, kHeader);
  EXPECT_EQ(samples_of(parsed.samples), ramp());
  EXPECT_EQ(parsed.samples.data(), packet.data() + 28) << "no copy";
}

TEST(MicrophonePacket, RefusesWhatIsNone) {
  const std::vector<std::byte> good = encode_packet(kHeader, ramp()).value();
  const auto code = [](std::vector<std::byte> bytes) { return parse_packet(bytes).error().code; };
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_EQ(code({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)}), ErrorCode::truncated);
  std::vector<std::byte> longer = good;
  longer.push_back(std::byte{0});
  EXPECT_EQ(code(longer), ErrorCode::malformed);
  const auto with = [&](std::size_t at, int value) {
    std::vector<std::byte> changed = good;
    changed[at] = static_cast<std::byte>(value);
    return changed;
  };
  EXPECT_EQ(code(with(0, 'm')), ErrorCode::malformed);
  EXPECT_EQ(code(with(4, 2)), ErrorCode::unsupported);
  EXPECT_EQ(code(with(5, 13)), ErrorCode::unsupported);
  EXPECT_EQ(code(with(300, 7)), ErrorCode::malformed) << "the checksum";
  EXPECT_EQ(code(summed(with(7, 1))), ErrorCode::malformed);
  EXPECT_EQ(code(summed(with(27, 1))), ErrorCode::malformed);
  EXPECT_EQ(code(summed(with(23, 1))), ErrorCode::out_of_range) << "a block of the far future";
  EXPECT_EQ(code(summed(with(8, 0))), ErrorCode::out_of_range) << "nobody there is this machine";
  EXPECT_EQ(encode_packet({.device = 1, .block = kMostBlocks}, ramp()).error().code, ErrorCode::out_of_range);
}

TEST(MicrophonePacket, IsOneOfTheTwoFormsThatALogHas) {
  const std::vector<std::byte> packet = encode_packet(kHeader, ramp()).value();
  const std::vector<std::byte> header = encode_header(kHeader).value();
  for (const auto& logged : {logged_block(packet, {}), logged_block(header, payload_of(ramp()))}) {
    ASSERT_TRUE(logged);
    EXPECT_EQ(logged->header, kHeader);
    EXPECT_EQ(logged->block, ramp());
  }
  EXPECT_FALSE(logged_block(header, {}));
  EXPECT_FALSE(logged_block(std::span(packet).first(100), {}));
}

TEST(MicrophoneProtocol, MakesASampleWhoseBlockIsPartOfThePacket) {
  MicrophoneProtocol protocol;
  const std::vector<std::byte> packet = encode_packet(kHeader, ramp()).value();
  EXPECT_TRUE(protocol.recognises(packet));
  EXPECT_FALSE(protocol.recognises(encode_header(kHeader).value()));
  EXPECT_FALSE(SoundProtocol().recognises(packet)) << "what is heard here is another language";
  sensor::Inbox inbox;
  ASSERT_EQ(protocol.receive({}, 0, packet, inbox), Verdict::taken);
  ASSERT_EQ(inbox.readings.size(), 1U);
  EXPECT_EQ(inbox.readings[0].from, (sensor::DeviceKey{kAnyMicrophone, 0}));
  EXPECT_EQ(inbox.readings[0].sample.kind, sensor::SampleKind::sound);
  EXPECT_EQ(inbox.readings[0].sample.time, DeviceTime(std::chrono::milliseconds(20'010)));
  EXPECT_EQ(samples_of(inbox.readings[0].payload), ramp());
  EXPECT_EQ(inbox.readings[0].payload.data(), packet.data() + 28);
}

TEST(MicrophoneProtocol, LeavesNoTraceOfWhatIsMalformed) {
  MicrophoneProtocol protocol;
  std::vector<std::byte> packet = encode_packet(kHeader, ramp()).value();
  sensor::Inbox inbox;
  EXPECT_EQ(protocol.receive({}, 0, std::span(packet).first(100), inbox), Verdict::malformed);
  EXPECT_EQ(protocol.receive_with_payload({}, 0, packet, payload_of(ramp()), inbox), Verdict::malformed)
      << "it has its samples";
  packet[4] = std::byte{2};
  EXPECT_EQ(protocol.receive({}, 0, packet, inbox), Verdict::malformed)
      << "what is ignored is logged, and it holds a voice";
  EXPECT_TRUE(inbox.readings.empty());
}

}  // namespace
}  // namespace mien::speech::microphone_protocol_test
