#include "mien/eyewear/packet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "mien/core/cobs.h"
#include "mien/core/random.h"
#include "tests/hex.h"
#include "tests/wrong_packets.h"

namespace mien::eyewear::packet_test {
namespace {

using sensor::Sample;
using sensor::SampleKind;

Packet three() {
  Packet packet;
  packet.channels = 3;
  packet.device = 0x024D49454E40;
  packet.sequence = 258;
  packet.battery_percent = 87;
  packet.time = DeviceTime(std::chrono::microseconds(1'234'567));
  packet.light[0] = {612, 37};
  packet.light[1] = {1023, 512};
  packet.light[2] = {0, 0};
  return packet;
}

std::vector<std::byte> encoded(const Packet& packet) {
  auto bytes = encode_packet(packet);
  EXPECT_TRUE(bytes) << bytes.error().message();
  return bytes ? *bytes : std::vector<std::byte>();
}

// The test vectors of docs/reference/protocol.md: whoever writes a device's firmware checks against the same
// bytes.
TEST(EyewearPacket, MatchesTheDocumentsBytes) {
  const auto bytes = encoded(three());
  EXPECT_EQ(
      hex(bytes),
      "4d49454e0108030a404e45494d020000020100005700000087d612000000000064022500ff030002000000003c008494");
  std::vector<std::byte> frame;
  cobs_encode(bytes, frame);
  EXPECT_EQ(
      hex(frame),
      "0f4d49454e0108030a404e45494d020103020101025701010487d612010101010464022503ff030202010101023c038494");
}

TEST(EyewearPacket, ComesBackAsItWent) {
  Random random(7);
  for (std::uint8_t bits = kMinAdcBits; bits <= kMaxAdcBits; ++bits) {
    Packet packet = three();
    packet.adc_bits = bits;
    packet.channels = static_cast<std::uint8_t>(bits == kMinAdcBits ? 1 : bits == kMaxAdcBits ? 64 : 20);
    packet.light = {};
    for (std::size_t c = 0; c < packet.channels; ++c)
      packet.light[c] = {static_cast<std::uint16_t>(random.below(packet.full_scale() + 1U)),
                         static_cast<std::uint16_t>(random.below(packet.full_scale() + 1U))};
    const auto bytes = encoded(packet);
    EXPECT_EQ(bytes.size(), 36U + 4U * packet.channels);
    EXPECT_TRUE(is_packet(bytes));
    const auto back = parse_packet(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, packet);
    EXPECT_EQ(encoded(*back), bytes);
  }
}

TEST(EyewearPacket, RefusesEveryTruncationAndTrailingBytes) {
  expect_refuses_truncation_and_trailing_bytes(encoded(three()), parse_packet);
}

TEST(EyewearPacket, RefusesEveryFlippedBit) {
  expect_refuses_flipped_bits(encoded(three()), parse_packet);
}

TEST(EyewearPacket, RefusesEachWrongFieldAlone) {
  const std::vector<WrongField> cases = {
      {"magic", 0, {'X'}, ErrorCode::malformed},
      {"version", 4, {2}, ErrorCode::unsupported},
      {"type", 5, {1}, ErrorCode::unsupported},
      {"no channels", 6, {0}, ErrorCode::out_of_range},
      {"65 channels", 6, {65}, ErrorCode::out_of_range},
      {"more channels than bytes", 6, {4}, ErrorCode::truncated},
      {"fewer channels than bytes", 6, {2}, ErrorCode::malformed},
      {"7 bits", 7, {7}, ErrorCode::out_of_range},
      {"17 bits", 7, {17}, ErrorCode::out_of_range},
      {"battery", 20, {101}, ErrorCode::out_of_range},
      {"reserved, first", 21, {1}, ErrorCode::malformed},
      {"reserved, last", 23, {1}, ErrorCode::malformed},
      {"time", 24, {255, 255, 255, 255, 255, 255, 255, 255}, ErrorCode::out_of_range},
      {"time, by one", 24, {0x01, 0x40, 0x7a, 0x10, 0xf3, 0x5a, 0, 0}, ErrorCode::out_of_range},
      {"LED on beyond the range", 32, {0, 4}, ErrorCode::out_of_range},
      {"LED off beyond the range", 42, {0xff, 0xff}, ErrorCode::out_of_range},
  };
  expect_refuses_wrong_fields(encoded(three()), cases, parse_packet);
}

TEST(EyewearPacket, RandomBytesNeverPass) {
  Random random(5);
  const auto head = encoded(three());
  for (int i = 0; i < 20'000; ++i) {
    std::vector<std::byte> bytes(random.below(160));
    for (auto& b : bytes) b = std::byte{static_cast<unsigned char>(random.bits() & 255U)};
    std::copy_n(head.begin(), std::min<std::size_t>(bytes.size(), 8), bytes.begin());
    EXPECT_FALSE(parse_packet(bytes));
  }
}

TEST(EyewearPacket, GivesSharesOfFullScale) {
  const Packet packet = three();
  const Sample first = sample_of(packet, 0, 9);
  EXPECT_EQ(first.sensor, 9);
  EXPECT_EQ(first.kind, SampleKind::eyewear_light);
  EXPECT_EQ(first.sequence, 258u);
  EXPECT_EQ(first.time, packet.time);
  EXPECT_FALSE(first.time_estimated);
  ASSERT_EQ(first.count, 2);
  EXPECT_FLOAT_EQ(first.values[0], 612.0F / 1023);
  EXPECT_FLOAT_EQ(first.values[1], 37.0F / 1023);
  EXPECT_FALSE(is_saturated(packet, 0));
  EXPECT_EQ(sample_of(packet, 1, 0).values[0], 1.0F);
  EXPECT_TRUE(is_saturated(packet, 1));
  EXPECT_EQ(sample_of(packet, 2, 0).values[0], 0.0F);
  EXPECT_FALSE(is_saturated(packet, 2));  // Dark is a reading.
}

TEST(EyewearPacket, EveryStepSurvivesAsASample) {
  Packet packet = three();
  packet.channels = 1;
  packet.light = {};
  for (const std::uint8_t bits : {std::uint8_t{8}, std::uint8_t{10}, std::uint8_t{16}}) {
    packet.adc_bits = bits;
    for (unsigned step = 0; step <= packet.full_scale(); ++step) {
      packet.light[0] = {static_cast<std::uint16_t>(step),
                         static_cast<std::uint16_t>(packet.full_scale() - step)};
      const Sample sample = sample_of(packet, 0, 0);
      const auto again = make_packet({&sample, 1}, bits);
      ASSERT_TRUE(again);
      ASSERT_EQ(again->light, packet.light);
    }
  }
}

TEST(EyewearPacket, MakesAScanOfSamples) {
  const Packet packet = three();
  std::vector<Sample> scan;
  for (std::size_t c = 0; c < packet.channels; ++c)
    scan.push_back(sample_of(packet, c, static_cast<std::uint16_t>(c)));
  auto again = make_packet(scan, packet.adc_bits);
  ASSERT_TRUE(again) << again.error().message();
  again->device = packet.device;
  again->battery_percent = packet.battery_percent;
  EXPECT_EQ(*again, packet);

  const auto code = [&](auto&& change, std::uint8_t bits = 10) {
    auto changed = scan;
    change(changed);
    const auto made = make_packet(changed, bits);
    EXPECT_FALSE(made);
    return made ? ErrorCode::internal : made.error().code;
  };
  EXPECT_EQ(code([](auto& s) { s.clear(); }), ErrorCode::bad_usage);
  EXPECT_EQ(code([](auto& s) { s.resize(65); }), ErrorCode::bad_usage);
  EXPECT_EQ(code([](auto& s) { s[1].kind = SampleKind::imu_raw; }), ErrorCode::bad_usage);
  EXPECT_EQ(code([](auto& s) { s[1].count = 1; }), ErrorCode::bad_usage);
  EXPECT_EQ(code([](auto& s) { s[2].time += Duration(1); }), ErrorCode::bad_usage);
  EXPECT_EQ(code([](auto& s) { ++s[2].sequence; }), ErrorCode::bad_usage);
  EXPECT_EQ(code([](auto& s) { s[0].values[1] = std::numeric_limits<float>::quiet_NaN(); }),
            ErrorCode::out_of_range);
  EXPECT_EQ(code([](auto&) {}, 7), ErrorCode::out_of_range);
  for (Sample& sample : scan) sample.time = DeviceTime(Duration(-1));
  EXPECT_EQ(code([](auto&) {}), ErrorCode::out_of_range);
}

TEST(EyewearPacket, SaturatesAsTheConverterDoes) {
  Sample sample;
  sample.kind = SampleKind::eyewear_light;
  sample.count = 2;
  sample.values[0] = 1.7F;
  sample.values[1] = -0.2F;
  const auto packet = make_packet({&sample, 1}, 12);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->light[0], (Light{4095, 0}));
  EXPECT_TRUE(is_saturated(*packet, 0));
}

TEST(EyewearPacket, WritesNothingThatItWouldNotRead) {
  Packet packet = three();
  packet.light[1].off = 1024;
  EXPECT_EQ(encode_packet(packet).error().code, ErrorCode::out_of_range);
  packet = three();
  packet.channels = 0;
  EXPECT_EQ(encode_packet(packet).error().code, ErrorCode::out_of_range);
  packet = three();
  packet.time = DeviceTime(Duration(-1));
  EXPECT_EQ(encode_packet(packet).error().code, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::eyewear::packet_test
