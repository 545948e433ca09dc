#include "mien/gaze/packet.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"
#include "tests/hex.h"
#include "tests/wrong_packets.h"

namespace mien::gaze::packet_test {
namespace {

/// The left eye 0.25 rad to the performer's left and 0.125 rad down, half open, a pupil of 3.5 mm, sure of
/// it.
Packet looking() {
  Packet packet;
  packet.device = 0x024D49454E60;
  packet.sequence = 258;
  packet.battery_percent = 87;
  packet.time = DeviceTime(std::chrono::microseconds(1'234'567));
  packet.eyes[0] = {
      .yaw_rad = 0.25F, .pitch_rad = -0.125F, .confidence = 1, .openness = 127.0F / 254, .pupil_mm = 3.5F};
  return packet;  // The right eye is not seen.
}

std::vector<std::byte> encoded(const Packet& packet) {
  auto bytes = encode_packet(packet);
  EXPECT_TRUE(bytes) << bytes.error().message();
  return bytes ? *bytes : std::vector<std::byte>();
}

// The test vector of docs/reference/protocol.md: whoever writes a sender checks against the same bytes.
TEST(GazePacket, MatchesTheDocumentsBytes) {
  EXPECT_EQ(hex(encoded(looking())),
            "4d49454e010b5700604e45494d020000020100000000000087d6120000000000"
            "0000803e000000be7ffe5e01"
            "0000000000000000ff00ffff"
            "07764c5a");
}

TEST(GazePacket, ComesBackAsItWent) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    Packet packet = looking();
    for (Eye& eye : packet.eyes) {
      eye = {.yaw_rad = static_cast<float>(random.uniform(-1.57, 1.57)),
             .pitch_rad = static_cast<float>(random.uniform(-1.57, 1.57)),
             .confidence = static_cast<float>(random.below(255)) / 254};
      if (random.chance(0.5)) eye.openness = static_cast<float>(random.below(255)) / 254;
      if (random.chance(0.5)) eye.pupil_mm = static_cast<float>(random.below(2001)) / 100;
    }
    const auto bytes = encoded(packet);
    EXPECT_TRUE(is_packet(bytes));
    const auto back = parse_packet(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, packet);
    EXPECT_EQ(encoded(*back), bytes);
    EXPECT_EQ(eyes_of(sample_of(packet.eyes)), packet.eyes);
  }
}

TEST(GazePacket, RefusesEveryTruncationAndTrailingBytes) {
  expect_refuses_truncation_and_trailing_bytes(encoded(looking()), parse_packet);
}

TEST(GazePacket, RefusesEveryFlippedBit) {
  expect_refuses_flipped_bits(encoded(looking()), parse_packet);
}

TEST(GazePacket, RefusesEachWrongFieldAlone) {
  const std::vector<WrongField> cases = {
      {"magic", 0, {'X'}, ErrorCode::malformed},
      {"version", 4, {2}, ErrorCode::unsupported},
      {"type", 5, {8}, ErrorCode::unsupported},
      {"battery", 6, {101}, ErrorCode::out_of_range},
      {"reserved, first", 7, {1}, ErrorCode::malformed},
      {"reserved, last", 23, {1}, ErrorCode::malformed},
      {"time", 24, {0x01, 0x40, 0x7a, 0x10, 0xf3, 0x5a, 0, 0}, ErrorCode::out_of_range},
      {"yaw is infinite", 32, {0, 0, 0x80, 0x7f}, ErrorCode::out_of_range},
      {"pitch is not a number", 36, {0, 0, 0xc0, 0x7f}, ErrorCode::out_of_range},
      {"yaw beyond a quarter turn", 44, {0xdc, 0x0f, 0xc9, 0x3f}, ErrorCode::out_of_range},
      {"confidence", 41, {255}, ErrorCode::out_of_range},
      {"pupil of 20.01 mm", 42, {0xd1, 0x07}, ErrorCode::out_of_range},
  };
  expect_refuses_wrong_fields(encoded(looking()), cases, parse_packet);
}

TEST(GazePacket, ASampleOfOtherThingsHasNoEyes) {
  sensor::Sample sample = sample_of(looking().eyes);
  sample.count = 9;
  EXPECT_FALSE(eyes_of(sample));
  sample = sample_of(looking().eyes);
  sample.kind = sensor::SampleKind::eyewear_light;
  EXPECT_FALSE(eyes_of(sample));
  sample = sample_of(looking().eyes);
  sample.values[0] = 2;
  EXPECT_FALSE(eyes_of(sample));
}

}  // namespace
}  // namespace mien::gaze::packet_test
