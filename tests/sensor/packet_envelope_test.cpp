#include "mien/sensor/packet_envelope.h"

#include <gtest/gtest.h>

#include <vector>

namespace mien::sensor::packet_envelope_test {
namespace {

const char* const kWhere = "a packet";

std::vector<std::byte> small(std::uint8_t type) {
  ByteWriter out;
  out.append("before");
  const std::size_t begin = out.bytes().size();
  write_packet_begin(type, out);
  write_device_time(DeviceTime(std::chrono::microseconds(123'456'789)), out);
  write_checksum(begin, out);
  return {out.bytes().begin() + static_cast<std::ptrdiff_t>(begin), out.bytes().end()};
}

TEST(PacketEnvelope, ReadsWhatItWrites) {
  const std::vector<std::byte> packet = small(7);
  ASSERT_EQ(packet.size(), 4u + 1 + 1 + 8 + kChecksumBytes);
  EXPECT_EQ(packet[0], std::byte{'M'});
  EXPECT_EQ(packet[4], std::byte{kPacketVersion});
  EXPECT_TRUE(is_our_packet(packet));
  EXPECT_TRUE(is_our_packet(packet, 7));
  EXPECT_FALSE(is_our_packet(packet, 8));
  EXPECT_FALSE(is_our_packet(std::span(packet).first(5)));
  ByteReader reader(packet);
  EXPECT_EQ(read_packet_begin(reader, kWhere).value(), 7);
  EXPECT_EQ(read_device_time(reader, kWhere).value(), DeviceTime(std::chrono::microseconds(123'456'789)));
  EXPECT_TRUE(check_checksum(packet, kWhere));
}

TEST(PacketEnvelope, RefusesOthersAndWhatWasChanged) {
  for (std::size_t i = 0; i < small(7).size(); ++i) {
    std::vector<std::byte> packet = small(7);
    packet[i] ^= std::byte{0x40};
    EXPECT_EQ(check_checksum(packet, kWhere).error().code, ErrorCode::malformed) << i;
    ByteReader reader(packet);
    const auto type = read_packet_begin(reader, kWhere);
    if (i < 4) {
      EXPECT_EQ(type.error().code, ErrorCode::malformed);
      EXPECT_FALSE(is_our_packet(packet));
    } else if (i == 4) {
      EXPECT_EQ(type.error().code, ErrorCode::unsupported);
      EXPECT_TRUE(is_our_packet(packet)) << "of another version";
    } else {
      EXPECT_TRUE(type);
    }
  }
  ByteReader nothing(std::span<const std::byte>{});
  EXPECT_EQ(read_packet_begin(nothing, kWhere).error().code, ErrorCode::malformed);
  EXPECT_TRUE(check_length(8, 8, kWhere));
  EXPECT_EQ(check_length(7, 8, kWhere).error().code, ErrorCode::truncated);
  EXPECT_EQ(check_length(9, 8, kWhere).error().code, ErrorCode::malformed);
}

TEST(PacketEnvelope, TimesAndBatteriesHaveTheirRanges) {
  constexpr std::int64_t kLastUs = 100'000'000'000'000;
  EXPECT_TRUE(check_device_time(DeviceTime{}, kWhere));
  EXPECT_TRUE(check_device_time(DeviceTime(std::chrono::microseconds(kLastUs)), kWhere));
  for (const Duration out : {Duration(-1), Duration(kLastUs * 1000 + 1)})
    EXPECT_EQ(check_device_time(DeviceTime(out), kWhere).error().code, ErrorCode::out_of_range);
  ByteWriter writer;
  writer.little(static_cast<std::uint64_t>(kLastUs));
  writer.little(static_cast<std::uint64_t>(kLastUs + 1));
  ByteReader reader(writer.bytes());
  EXPECT_TRUE(read_device_time(reader, kWhere));
  EXPECT_EQ(read_device_time(reader, kWhere).error().code, ErrorCode::out_of_range);
  for (const int percent : {0, 100, 255})
    EXPECT_TRUE(check_battery(static_cast<std::uint8_t>(percent), kWhere)) << percent;
  for (const int percent : {101, 254})
    EXPECT_FALSE(check_battery(static_cast<std::uint8_t>(percent), kWhere)) << percent;
}

}  // namespace
}  // namespace mien::sensor::packet_envelope_test
