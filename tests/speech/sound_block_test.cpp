#include "mien/speech/sound_block.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mien/core/bytes.h"
#include "mien/speech/sound_protocol.h"

namespace mien::speech::sound_block_test {
namespace {

using sensor::Verdict;

std::vector<std::byte> hex(std::string_view text) {
  std::vector<std::byte> out;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    out.push_back(static_cast<std::byte>(std::stoi(std::string(text.substr(i, 2)), nullptr, 16)));
  return out;
}

/// With the checksum that belongs to it.
std::vector<std::byte> sealed(std::vector<std::byte> packet) {
  const std::uint32_t sum = crc32(std::span(packet).first(packet.size() - 4));
  for (std::size_t i = 0; i < 4; ++i)
    packet[packet.size() - 4 + i] = static_cast<std::byte>((sum >> (8 * i)) & 0xFFU);
  return packet;
}

const BlockHeader kHeader = {.device = 0x024D'4953'4E00ULL, .block = 1'000};

TEST(SoundBlock, HasTheLayoutOfTheProtocolPage) {
  const std::vector<std::byte> packet = encode_header(kHeader).value();
  ASSERT_EQ(packet.size(), kHeaderBytes);
  // magic, version 1, type 13, reserved, device, block, reserved; the checksum is of all before it.
  EXPECT_EQ(packet, sealed(hex("4d49454e010d0000"
                               "004e53494d020000"
                               "e803000000000000"
                               "0000000000000000")));
  EXPECT_EQ(parse_header(packet).value(), kHeader);
  EXPECT_EQ(kHeader.time(), DeviceTime(std::chrono::seconds(20))) << "20 ms a block";
}

TEST(SoundBlock, RefusesWhatIsNone) {
  const std::vector<std::byte> good = encode_header(kHeader).value();
  const auto code = [](std::vector<std::byte> bytes) { return parse_header(bytes).error().code; };
  for (std::size_t length = 0; length < good.size(); ++length)
    EXPECT_EQ(code({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)}), ErrorCode::truncated);
  std::vector<std::byte> bytes = good;
  bytes.push_back(std::byte{0});
  EXPECT_EQ(code(bytes), ErrorCode::malformed);
  const auto with = [&](std::size_t at, int value) {
    std::vector<std::byte> changed = good;
    changed[at] = static_cast<std::byte>(value);
    return changed;
  };
  EXPECT_EQ(code(with(0, 'm')), ErrorCode::malformed);
  EXPECT_EQ(code(with(4, 2)), ErrorCode::unsupported);
  EXPECT_EQ(code(with(5, 11)), ErrorCode::unsupported);
  EXPECT_EQ(code(with(9, 1)), ErrorCode::malformed) << "the checksum";
  EXPECT_EQ(code(sealed(with(6, 1))), ErrorCode::malformed);
  EXPECT_EQ(code(sealed(with(24, 1))), ErrorCode::malformed);
  EXPECT_EQ(code(sealed(with(23, 1))), ErrorCode::out_of_range) << "a block of the far future";
  EXPECT_EQ(encode_header({.device = 1, .block = kMostBlocks}).error().code, ErrorCode::out_of_range);
}

TEST(SoundBlock, ItsSamplesAreThePayload) {
  Block block;
  for (std::size_t i = 0; i < block.size(); ++i)
    block[i] = static_cast<std::int16_t>(257 * static_cast<int>(i) - 32'768);
  const auto payload = payload_of(block);
  EXPECT_EQ(payload[0], std::byte{0x00});
  EXPECT_EQ(payload[1], std::byte{0x80});
  EXPECT_EQ(samples_of(payload), block);
  EXPECT_FALSE(samples_of(std::span(payload).first(kBlockBytes - 1)));
  EXPECT_FALSE(samples_of({}));
}

TEST(SoundBlock, TellsHowLoudItIs) {
  Block block{};
  EXPECT_EQ(loudness_of(block).rms, 0);
  EXPECT_EQ(loudness_of(block).peak, 0);
  block.fill(-32'768);
  EXPECT_EQ(loudness_of(block).rms, 1);
  EXPECT_EQ(loudness_of(block).peak, 1);
  for (std::size_t i = 0; i < block.size(); ++i)
    block[i] = static_cast<std::int16_t>(
        std::lround(16'384 * std::sin(2 * std::numbers::pi * 200 * static_cast<double>(i) / kRateHz)));
  EXPECT_NEAR(loudness_of(block).rms, 0.5 / std::numbers::sqrt2, 1e-4);
  EXPECT_NEAR(loudness_of(block).peak, 0.5, 1e-4);
}

TEST(SoundProtocol, MakesASampleOfABlock) {
  SoundProtocol protocol;
  const std::vector<std::byte> header = encode_header(kHeader).value();
  EXPECT_TRUE(protocol.recognises(header));
  Block block{};
  block[7] = 8'192;
  const auto payload = payload_of(block);
  sensor::Inbox inbox;
  ASSERT_EQ(protocol.receive_with_payload({}, 0, header, payload, inbox), Verdict::taken);
  ASSERT_EQ(inbox.readings.size(), 1u);
  const sensor::Reading& reading = inbox.readings[0];
  EXPECT_EQ(reading.from, (sensor::DeviceKey{kHeader.device, 0}));
  EXPECT_EQ(reading.sample.kind, sensor::SampleKind::sound);
  EXPECT_EQ(reading.sample.sequence, 1'000u);
  EXPECT_EQ(reading.sample.time, DeviceTime(std::chrono::milliseconds(20'010)));
  EXPECT_THAT(reading.sample.used(),
              testing::ElementsAre(testing::FloatNear(0.25F / std::sqrt(320.0F), 1e-6F), 0.25F));
  EXPECT_EQ(reading.payload.data(), payload.data());
}

TEST(SoundProtocol, LeavesNoTraceOfWhatIsMalformed) {
  SoundProtocol protocol;
  std::vector<std::byte> header = encode_header(kHeader).value();
  const auto payload = payload_of({});
  sensor::Inbox inbox;
  EXPECT_EQ(protocol.receive({}, 0, header, inbox), Verdict::malformed) << "without its block";
  EXPECT_EQ(protocol.receive_with_payload({}, 0, header, std::span(payload).first(100), inbox),
            Verdict::malformed);
  header[9] ^= std::byte{1};
  EXPECT_EQ(protocol.receive_with_payload({}, 0, header, payload, inbox), Verdict::malformed);
  EXPECT_TRUE(inbox.readings.empty());
  header = sealed([&] {
    std::vector<std::byte> other = encode_header(kHeader).value();
    other[5] = std::byte{14};
    return other;
  }());
  EXPECT_FALSE(protocol.recognises(header));
  EXPECT_EQ(protocol.receive_with_payload({}, 0, header, payload, inbox), Verdict::ignored);
}

}  // namespace
}  // namespace mien::speech::sound_block_test
