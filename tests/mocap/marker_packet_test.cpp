#include "mien/mocap/marker_packet.h"

#include <gtest/gtest.h>

#include <string>

#include "mien/core/bytes.h"
#include "mien/mocap/marker_track.h"
#include "tests/hex.h"

namespace mien::mocap::marker_packet_test {
namespace {

const std::vector<std::string> kNames = {"tip", "chin_L"};
constexpr std::uint64_t kServer = 0x024D49454E50;

MarkerPositionsPacket two() {
  MarkerPositionsPacket packet;
  packet.device = kServer;
  packet.sequence = 258;
  packet.list = marker_list(kNames);
  packet.time = DeviceTime(std::chrono::microseconds(1'234'567));
  packet.count = 2;
  packet.position_m[0] = Vec3f(-0.0125F, 1.5F, 0.00025F);
  packet.position_m[1] = kLostMarker;
  return packet;
}

/// The bytes with another one at `offset`, and a checksum that fits again.
std::vector<std::byte> changed(std::vector<std::byte> bytes, std::size_t offset, int value) {
  bytes[offset] = static_cast<std::byte>(value);
  ByteWriter writer;
  writer.append(std::span(bytes).first(bytes.size() - 4));
  writer.little(crc32(writer.bytes()));
  return writer.release();
}

ErrorCode code_of(std::span<const std::byte> bytes) {
  const auto packet = parse_marker_packet(bytes);
  return packet ? ErrorCode::internal : packet.error().code;
}

// The test vectors of docs/reference/protocol.md, made by hand: whoever writes a server checks against the
// same bytes.
TEST(MarkerPacket, MatchesTheDocumentsBytes) {
  const auto names = encode_marker_names(kServer, kNames);
  ASSERT_TRUE(names) << names.error().message();
  ASSERT_EQ(names->size(), 1u);
  EXPECT_EQ(hex(names->front()), "4d49454e01090200504e45494d020000e3ae36a30203746970066368696e5f4cef96919a");
  const auto positions = encode_marker_positions(two());
  ASSERT_TRUE(positions) << positions.error().message();
  EXPECT_EQ(hex(*positions),
            "4d49454e010a0200504e45494d02000002010000e3ae36a387d61200000000002ccfffff60e31600fa00000000000080"
            "00000080000000"
            "808ec98631");
}

TEST(MarkerPacket, ComesBackAsItWent) {
  const auto bytes = encode_marker_positions(two());
  ASSERT_TRUE(bytes);
  ASSERT_TRUE(is_marker_packet(*bytes));
  const auto packet = parse_marker_packet(*bytes);
  ASSERT_TRUE(packet) << packet.error().message();
  const auto& positions = std::get<MarkerPositionsPacket>(*packet);
  EXPECT_EQ(positions.device, kServer);
  EXPECT_EQ(positions.sequence, 258u);
  EXPECT_EQ(positions.list, marker_list(kNames));
  EXPECT_EQ(positions.time, two().time);
  ASSERT_EQ(positions.count, 2);
  EXPECT_TRUE(positions.position_m[0].isApprox(two().position_m[0], 1e-6F));
  EXPECT_FALSE(is_seen(positions.position_m[1]));
}

TEST(MarkerPacket, ManyNamesTakeSeveralPackets) {
  std::vector<std::string> many;
  for (int i = 0; i < 100; ++i) many.push_back("a_marker_of_a_long_name_" + std::to_string(i));
  const auto packets = encode_marker_names(kServer, many);
  ASSERT_TRUE(packets);
  EXPECT_GT(packets->size(), 1u);
  std::vector<std::string> received(100);
  for (const auto& bytes : *packets) {
    EXPECT_LE(bytes.size(), 1200u);
    const auto packet = parse_marker_packet(bytes);
    ASSERT_TRUE(packet) << packet.error().message();
    const auto& names = std::get<MarkerNamesPacket>(*packet);
    EXPECT_EQ(names.markers, 100);
    for (std::size_t i = 0; i < names.count; ++i) received[names.first + i] = names.names[i];
  }
  EXPECT_EQ(received, many);
}

TEST(MarkerPacket, WhatIsWrongIsRefused) {
  const std::vector<std::byte> good = *encode_marker_positions(two());
  const std::vector<std::byte> names = encode_marker_names(kServer, kNames)->front();
  EXPECT_EQ(code_of(changed(good, 0, 'm')), ErrorCode::malformed);
  EXPECT_EQ(code_of(changed(good, 4, 2)), ErrorCode::unsupported);
  EXPECT_EQ(code_of(changed(good, 5, 8)), ErrorCode::unsupported);
  EXPECT_EQ(code_of(changed(good, 6, 0)), ErrorCode::out_of_range);
  EXPECT_EQ(code_of(changed(good, 6, 101)), ErrorCode::out_of_range);
  EXPECT_EQ(code_of(changed(good, 6, 3)), ErrorCode::truncated);
  EXPECT_EQ(code_of(changed(good, 6, 1)), ErrorCode::malformed);
  EXPECT_EQ(code_of(changed(good, 7, 1)), ErrorCode::malformed);
  EXPECT_EQ(code_of(changed(good, 31, 0x7F)), ErrorCode::out_of_range);  // Time.
  EXPECT_EQ(code_of(changed(good, 35, 0x7F)), ErrorCode::out_of_range);  // Two kilometres.
  EXPECT_EQ(code_of(changed(good, 44, 1)), ErrorCode::malformed);        // Half lost.
  EXPECT_EQ(code_of(changed(names, 6, 1)), ErrorCode::out_of_range);     // Two names of one marker.
  EXPECT_EQ(code_of(changed(names, 7, 1)), ErrorCode::out_of_range);
  EXPECT_EQ(code_of(changed(names, 20, 0)), ErrorCode::out_of_range);
  EXPECT_EQ(code_of(changed(names, 20, 1)), ErrorCode::malformed);  // Bytes behind it.
  EXPECT_EQ(code_of(changed(names, 21, 0)), ErrorCode::malformed);  // An empty name.
  EXPECT_EQ(code_of(changed(names, 21, 60)), ErrorCode::truncated);
  EXPECT_EQ(code_of(changed(names, 22, ',')), ErrorCode::malformed);
  std::vector<std::byte> damaged = good;
  damaged[33] ^= std::byte{1};
  EXPECT_EQ(code_of(damaged), ErrorCode::malformed);
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(parse_marker_packet(std::span(good).first(size)));
}

TEST(MarkerPacket, WhatNobodyWouldTakeIsNotSent) {
  EXPECT_EQ(encode_marker_names(kServer, {}).error().code, ErrorCode::out_of_range);
  EXPECT_EQ(encode_marker_names(kServer, std::vector<std::string>(101, "a")).error().code,
            ErrorCode::out_of_range);
  EXPECT_EQ(encode_marker_names(kServer, std::vector<std::string>{"a,b"}).error().code, ErrorCode::malformed);
  MarkerPositionsPacket packet = two();
  packet.count = 0;
  EXPECT_EQ(encode_marker_positions(packet).error().code, ErrorCode::out_of_range);
  packet = two();
  packet.position_m[0].x() = 101;
  EXPECT_EQ(encode_marker_positions(packet).error().code, ErrorCode::out_of_range);
  packet = two();
  packet.time = DeviceTime(std::chrono::seconds(-1));
  EXPECT_EQ(encode_marker_positions(packet).error().code, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::mocap::marker_packet_test
