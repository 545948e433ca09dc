#include "mien/headset/picture_packet.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"
#include "tests/hex.h"
#include "tests/wrong_packets.h"

namespace mien::headset::picture_packet_test {
namespace {

/// The second picture of a board that has run for 1.234567 s.
PicturePacket looking() {
  return {.from = {.device = 0x024D49484401, .channel = 0},
          .sequence = 258,
          .time = DeviceTime(std::chrono::microseconds(1'234'567)),
          .first = false};
}

std::vector<std::byte> encoded(const PicturePacket& packet) {
  ByteWriter out;
  const auto written = write_picture_packet(packet, out);
  EXPECT_TRUE(written) << written.error().message();
  return out.release();
}

// The test vector of docs/reference/protocol.md.
TEST(PicturePacket, MatchesTheDocumentsBytes) {
  EXPECT_EQ(hex(encoded(looking())),
            "4d49454e010f0100014448494d020000020100000000000087d6120000000000fa72f8bc");
}

TEST(PicturePacket, ComesBackAsItWent) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    PicturePacket packet{.from = {.device = random.below(1'000'000), .channel = static_cast<std::uint8_t>(i)},
                         .sequence = static_cast<std::uint32_t>(random.below(1'000'000'000)),
                         .first = random.chance(0.5)};
    if (random.chance(0.5))
      packet.time =
          DeviceTime(std::chrono::microseconds(static_cast<std::int64_t>(random.below(1'000'000'000))));
    const auto bytes = encoded(packet);
    EXPECT_EQ(bytes.size(), kPicturePacketBytes);
    EXPECT_TRUE(is_picture_packet(bytes));
    const auto back = parse_picture_packet(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, packet);
  }
}

TEST(PicturePacket, IsWrittenBehindWhatIsThere) {
  ByteWriter out;
  out.append("before");
  ASSERT_TRUE(write_picture_packet(looking(), out));
  EXPECT_TRUE(parse_picture_packet(out.bytes().subspan(6)));
}

TEST(PicturePacket, RefusesATimeThatCannotBeWritten) {
  for (const std::int64_t us : {std::int64_t{-1}, std::int64_t{100'000'000'000'001}}) {
    PicturePacket packet = looking();
    packet.time = DeviceTime(std::chrono::microseconds(us));
    ByteWriter out;
    EXPECT_FALSE(write_picture_packet(packet, out));
    EXPECT_TRUE(out.bytes().empty());
  }
}

TEST(PicturePacket, RefusesEveryTruncationAndTrailingBytes) {
  expect_refuses_truncation_and_trailing_bytes(encoded(looking()), parse_picture_packet);
}

TEST(PicturePacket, RefusesEveryFlippedBit) {
  expect_refuses_flipped_bits(encoded(looking()), parse_picture_packet);
}

TEST(PicturePacket, RefusesEachWrongFieldAlone) {
  const std::vector<WrongField> cases = {
      {"magic", 0, {'X'}, ErrorCode::malformed},
      {"version", 4, {2}, ErrorCode::unsupported},
      {"type", 5, {14}, ErrorCode::unsupported},
      {"flags", 6, {5}, ErrorCode::malformed},
      {"a time where none is known", 6, {0}, ErrorCode::malformed},
      {"reserved, first", 20, {1}, ErrorCode::malformed},
      {"reserved, last", 23, {1}, ErrorCode::malformed},
      {"time", 24, {0x01, 0x40, 0x7a, 0x10, 0xf3, 0x5a, 0, 0}, ErrorCode::out_of_range},
  };
  expect_refuses_wrong_fields(encoded(looking()), cases, parse_picture_packet);
}

}  // namespace
}  // namespace mien::headset::picture_packet_test
