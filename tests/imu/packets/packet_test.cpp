#include "mien/imu/packets/packet.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <numbers>
#include <string>

#include "mien/core/bytes.h"
#include "mien/core/random.h"
#include "tests/hex.h"
#include "tests/wrong_packets.h"

namespace mien::imu::packet_test {
namespace {

using sensor::SampleKind;

Packet raw_packet() {
  Packet p;
  p.device = 0x024D49454E07;
  p.channel = 1;
  p.sequence = 258;
  p.battery_percent = 87;
  p.time = DeviceTime(std::chrono::microseconds(1'234'567));
  p.interval = Duration(4'166'667);
  p.count = 2;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 6; ++k) {
      const double steps = (k % 2 == 0 ? 1.0 : -1.0) * static_cast<double>(1000 * i + 100 * k + 1);
      p.values[i][k] = static_cast<float>(steps * (k < 3 ? gyro_step_rad_s(6) : accel_step_m_s2(2)));
    }
  return p;
}

Packet fused_packet() {
  Packet p;
  p.kind = SampleKind::imu_fused;
  p.device = 1;
  p.sequence = 7;
  p.time = DeviceTime(std::chrono::seconds(2));
  p.count = 1;
  p.gyro_range = 0;
  p.accel_range = 0;
  p.values[0] = {0.5F, 0.5F, -0.5F, 0.5F, 0.0F, 9.75F, -1.0F};
  return p;
}

Packet head_relative_packet() {
  Packet p;
  p.kind = SampleKind::imu_head_relative;
  p.device = 2;
  p.time_estimated = true;
  p.sequence = 0xFFFFFFFF;
  p.time = DeviceTime(std::chrono::microseconds(16'667));
  p.count = 1;
  p.gyro_range = 0;
  p.accel_range = 0;
  p.values[0] = {0.125F, -0.25F, 0.0F};
  return p;
}

std::vector<std::byte> encoded(const Packet& packet) {
  auto bytes = encode_packet(packet);
  EXPECT_TRUE(bytes) << bytes.error().message();
  return bytes ? *bytes : std::vector<std::byte>();
}

// The test vectors of docs/reference/protocol.md: whoever writes a device's firmware checks against the same
// bytes.
TEST(Packet, MatchesTheDocumentsBytes) {
  EXPECT_EQ(hex(encoded(raw_packet())),
            "4d49454e01010100074e45494d020000020100000102572687d6120000000000"
            "0b943f0001009bffc900d3fe91010bfee903b3fbb104ebfa790523fa255607a6");
  EXPECT_EQ(hex(encoded(fused_packet())),
            "4d49454e010102000100000000000000070000000001ff0080841e0000000000"
            "000000000000003f0000003f000000bf0000003f0000000000001c41000080bf"
            "40846ab7");
  EXPECT_EQ(hex(encoded(head_relative_packet())),
            "4d49454e010103020200000000000000ffffffff0001ff001b41000000000000"
            "000000000000003e000080be00000000926ca6d5");
}

TEST(Packet, ComesBackAsItWent) {
  Packet nine = raw_packet();
  nine.magnetometer = true;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 6; k < 9; ++k) nine.values[i][k] = static_cast<float>(-437.0 * kMagStepTesla);
  for (const Packet& packet : {raw_packet(), nine, fused_packet(), head_relative_packet()}) {
    const auto bytes = encoded(packet);
    EXPECT_TRUE(is_packet(bytes));
    const auto back = parse_packet(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, packet);
    EXPECT_EQ(encoded(*back), bytes);
  }
}

TEST(Packet, EveryStepOfTheChipSurvives) {
  Packet packet = raw_packet();
  packet.count = 1;
  for (std::uint8_t gyro = 0; gyro <= 6; ++gyro)
    for (int steps = -32768; steps <= 32767; steps += 97) {
      packet.gyro_range = gyro;
      packet.accel_range = gyro % 4;
      packet.values[0].fill(0);
      packet.values[0][0] = static_cast<float>(steps * gyro_step_rad_s(gyro));
      packet.values[0][3] = static_cast<float>(steps * accel_step_m_s2(gyro % 4));
      const auto back = parse_packet(encoded(packet));
      ASSERT_TRUE(back);
      EXPECT_EQ(back->values[0], packet.values[0]);
    }
}

TEST(Packet, SaturatesAsTheChipDoes) {
  Packet packet = raw_packet();
  packet.values[0][0] = 100.0F;  // rad/s, of a full scale of 17.9.
  packet.values[0][3] = -1e6F;
  const auto back = parse_packet(encoded(packet));
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->values[0][0], 1024 * std::numbers::pi / 180, 1e-3);
  EXPECT_NEAR(back->values[0][3], -8 * 9.80665, 1e-3);
}

TEST(Packet, RefusesEveryTruncationAndTrailingBytes) {
  for (const Packet& packet : {raw_packet(), fused_packet(), head_relative_packet()})
    expect_refuses_truncation_and_trailing_bytes(encoded(packet), parse_packet);
}

TEST(Packet, RefusesEveryFlippedBit) {
  expect_refuses_flipped_bits(encoded(raw_packet()), parse_packet);
}

TEST(Packet, RefusesEachWrongFieldAlone) {
  const std::vector<WrongField> cases = {
      {"magic", 0, {'X'}, ErrorCode::malformed},
      {"version", 4, {2}, ErrorCode::unsupported},
      {"type", 5, {9}, ErrorCode::unsupported},
      {"kind 0", 6, {0}, ErrorCode::unsupported},
      {"kind 77", 6, {77}, ErrorCode::unsupported},
      {"reserved flag", 7, {4}, ErrorCode::malformed},
      {"no samples", 21, {0}, ErrorCode::out_of_range},
      {"17 samples", 21, {17}, ErrorCode::out_of_range},
      {"more samples than bytes", 21, {16}, ErrorCode::truncated},
      {"battery", 22, {101}, ErrorCode::out_of_range},
      {"gyro range", 23, {0x27}, ErrorCode::out_of_range},
      {"accel range", 23, {0x46}, ErrorCode::out_of_range},
      {"time", 24, {255, 255, 255, 255, 255, 255, 255, 255}, ErrorCode::out_of_range},
      {"interval 0 of two", 32, {0, 0, 0, 0}, ErrorCode::out_of_range},
      {"interval of seconds", 32, {255, 255, 255, 255}, ErrorCode::out_of_range},
  };
  expect_refuses_wrong_fields(encoded(raw_packet()), cases, parse_packet);
}

TEST(Packet, RefusesNumbersThatAreNone) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30F}) {
    for (const Packet& packet : {fused_packet(), head_relative_packet()}) {
      for (std::size_t k = 0; k < packet.values_per_sample(); ++k) {
        auto bytes = encoded(packet);
        std::memcpy(bytes.data() + 36 + 4 * k, &bad, 4);
        renew_checksum(bytes);
        EXPECT_FALSE(parse_packet(bytes)) << k;
        Packet changed = packet;
        changed.values[0][k] = bad;
        EXPECT_FALSE(encode_packet(changed));
      }
    }
  }
  Packet long_one = fused_packet();
  long_one.values[0][0] = 0.9F;
  EXPECT_FALSE(encode_packet(long_one));
  Packet magnetic = fused_packet();
  magnetic.magnetometer = true;
  EXPECT_FALSE(encode_packet(magnetic));
}

TEST(Packet, RandomBytesNeverPass) {
  Random random(5);
  for (int i = 0; i < 20'000; ++i) {
    std::vector<std::byte> bytes(random.below(160));
    for (auto& b : bytes) b = std::byte{static_cast<unsigned char>(random.bits() & 255U)};
    const auto head = encoded(raw_packet());
    std::copy_n(head.begin(), std::min<std::size_t>(bytes.size(), 6), bytes.begin());
    EXPECT_FALSE(parse_packet(bytes));
  }
}

TEST(Packet, SamplesKeepTheirTimes) {
  const Packet packet = raw_packet();
  std::vector<sensor::Sample> samples;
  append_samples(packet, 9, samples);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].sensor, 9);
  EXPECT_EQ(samples[0].sequence, 258u);
  EXPECT_EQ(samples[0].time, packet.time);
  EXPECT_EQ(samples[1].time - samples[0].time, packet.interval);
  EXPECT_EQ(samples[1].count, 6);
  const auto again = make_packet(samples);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->values, packet.values);
  EXPECT_EQ(again->interval, packet.interval);
  std::swap(samples[0], samples[1]);
  EXPECT_FALSE(make_packet(samples));
  samples[0].kind = SampleKind::imu_fused;
  EXPECT_FALSE(make_packet(samples));
  EXPECT_FALSE(make_packet({}));
}

}  // namespace
}  // namespace mien::imu::packet_test
