#include "mien/imu/packets/node_message.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/hex.h"

namespace mien::imu::node_message_test {
namespace {

constexpr std::uint64_t kDevice = 0x024D49454E07;
constexpr std::uint64_t kSession = 0x1122334455667788;

Hello hello() {
  return {.device = kDevice, .rate_hz = 240, .firmware = "0.1.0", .sites = {"zygomaticus_upper_L", ""}};
}
Welcome welcome() {
  return {
      .device = kDevice, .session = kSession, .heartbeat = std::chrono::milliseconds(500), .host = "studio"};
}
NodeHeartbeat heartbeat() {
  return {.device = kDevice, .battery_percent = 87, .time = DeviceTime(std::chrono::microseconds(1'234'567))};
}
HeartbeatEcho echo() {
  return {.device = kDevice, .time = DeviceTime(std::chrono::microseconds(1'234'567)), .session = kSession};
}
Pulse pulse() {
  return {.device = kDevice, .index = 258, .edge = DeviceTime(std::chrono::microseconds(1'234'567))};
}

std::vector<std::byte> encoded(const NodeMessage& message) {
  ByteWriter writer;
  const auto done = encode_node_message(message, writer);
  EXPECT_TRUE(done) << done.error().message();
  return writer.release();
}

ErrorCode refusal(std::vector<std::byte> bytes) {
  renew_checksum(bytes);
  const auto message = parse_node_message(bytes);
  EXPECT_FALSE(message);
  return message ? ErrorCode::internal : message.error().code;
}

ErrorCode refusal(const NodeMessage& message) {
  ByteWriter writer;
  const auto done = encode_node_message(message, writer);
  EXPECT_FALSE(done);
  EXPECT_TRUE(writer.bytes().empty());
  return done ? ErrorCode::internal : done.error().code;
}

// The test vectors of docs/reference/protocol.md.
TEST(NodeMessage, MatchesTheDocumentsBytes) {
  EXPECT_EQ(hex(encoded(hello())),
            "4d49454e01020000074e45494d02000080a903000205302e312e30137a79676f"
            "6d6174696375735f75707065725f4c00d50276a3");
  EXPECT_EQ(hex(encoded(welcome())),
            "4d49454e01030000074e45494d0200008877665544332211f401067374756469"
            "6f2f38f373");
  EXPECT_EQ(hex(encoded(heartbeat())), "4d49454e01045700074e45494d02000087d61200000000003e4df572");
  EXPECT_EQ(hex(encoded(echo())),
            "4d49454e01050000074e45494d02000087d61200000000008877665544332211"
            "e1c325b6");
  EXPECT_EQ(hex(encoded(pulse())), "4d49454e01060000074e45494d02000087d612000000000002010000666d0fde");
}

TEST(NodeMessage, ComesBackAsItWent) {
  Hello fast = hello();
  fast.rate_hz = 104.167;
  fast.sites.assign(kMaxNodeChannels, std::string(kMaxNodeText, 'x'));
  for (const NodeMessage& message : std::initializer_list<NodeMessage>{
           hello(), fast, welcome(), heartbeat(), NodeHeartbeat{.device = 1}, echo(), pulse()}) {
    const auto bytes = encoded(message);
    EXPECT_TRUE(is_node_packet(bytes));
    const auto back = parse_node_message(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, message);
    EXPECT_EQ(encoded(*back), bytes);
  }
}

TEST(NodeMessage, AppendsBehindWhatIsThere) {
  ByteWriter writer;
  writer.append("before");
  ASSERT_TRUE(encode_node_message(pulse(), writer));
  EXPECT_TRUE(parse_node_message(writer.bytes().subspan(6)));
}

TEST(NodeMessage, RefusesEveryLengthButItsOwn) {
  for (const NodeMessage& message :
       std::initializer_list<NodeMessage>{hello(), welcome(), heartbeat(), echo(), pulse()}) {
    const auto whole = encoded(message);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_FALSE(parse_node_message(cut)) << size;
      if (size >= 4) refusal(cut);
    }
    auto longer = whole;
    longer.push_back(std::byte{0});
    EXPECT_EQ(refusal(longer), ErrorCode::malformed);
  }
}

TEST(NodeMessage, RefusesEveryFlippedBit) {
  for (const NodeMessage& message : std::initializer_list<NodeMessage>{hello(), heartbeat()}) {
    auto bytes = encoded(message);
    for (std::size_t i = 0; i < bytes.size() * 8; ++i) {
      bytes[i / 8] ^= std::byte{1} << (i % 8);
      EXPECT_FALSE(parse_node_message(bytes)) << "bit " << i;
      bytes[i / 8] ^= std::byte{1} << (i % 8);
    }
  }
}

TEST(NodeMessage, RefusesForeignHeaders) {
  const auto changed = [](std::size_t at, std::uint8_t value) {
    auto bytes = encoded(pulse());
    bytes[at] = static_cast<std::byte>(value);
    return refusal(bytes);
  };
  EXPECT_EQ(changed(0, 'm'), ErrorCode::malformed);
  EXPECT_EQ(changed(4, 2), ErrorCode::unsupported);
  for (const int type : {0, 1, 7, 8, 255})
    EXPECT_EQ(changed(5, static_cast<std::uint8_t>(type)), ErrorCode::unsupported) << type;
  EXPECT_EQ(changed(6, 1), ErrorCode::malformed);
  EXPECT_EQ(changed(7, 1), ErrorCode::malformed);
}

TEST(NodeMessage, RefusesNumbersOutOfRange) {
  const auto with = [](NodeMessage message, std::size_t at, std::initializer_list<int> values) {
    auto bytes = encoded(message);
    for (const int value : values) bytes[at++] = static_cast<std::byte>(value);
    return refusal(bytes);
  };
  EXPECT_EQ(with(hello(), 16, {0xE7, 3, 0, 0}), ErrorCode::out_of_range);        // 0.999 Hz
  EXPECT_EQ(with(hello(), 16, {0x81, 0x96, 0x98, 0}), ErrorCode::out_of_range);  // 10,000.001 Hz
  EXPECT_EQ(with(hello(), 20, {17}), ErrorCode::out_of_range);
  EXPECT_EQ(with(hello(), 20, {3}), ErrorCode::truncated);
  EXPECT_EQ(with(hello(), 20, {1}), ErrorCode::malformed);
  EXPECT_EQ(with(hello(), 21, {65}), ErrorCode::truncated);
  EXPECT_EQ(with(hello(), 22, {7}), ErrorCode::malformed);
  EXPECT_EQ(with(hello(), 22, {0xC3, 0xA9}), ErrorCode::malformed);
  EXPECT_EQ(with(welcome(), 16, {0, 0, 0, 0, 0, 0, 0, 0}), ErrorCode::malformed);
  EXPECT_EQ(with(welcome(), 24, {99, 0}), ErrorCode::out_of_range);
  EXPECT_EQ(with(welcome(), 24, {0x11, 0x27}), ErrorCode::out_of_range);
  EXPECT_EQ(with(heartbeat(), 6, {101}), ErrorCode::out_of_range);
  EXPECT_EQ(with(heartbeat(), 16, {1, 0x40, 0x7A, 0x10, 0xF3, 0x5A}), ErrorCode::out_of_range);
  EXPECT_EQ(with(echo(), 24, {0, 0, 0, 0, 0, 0, 0, 0}), ErrorCode::malformed);
  EXPECT_EQ(with(pulse(), 16, {1, 0x40, 0x7A, 0x10, 0xF3, 0x5A}), ErrorCode::out_of_range);
}

TEST(NodeMessage, WritesNothingThatItWouldNotRead) {
  Hello bad = hello();
  bad.sites.clear();
  EXPECT_EQ(refusal(NodeMessage(bad)), ErrorCode::out_of_range);
  bad.sites.assign(kMaxNodeChannels + 1, "");
  EXPECT_EQ(refusal(NodeMessage(bad)), ErrorCode::out_of_range);
  bad = hello();
  for (const double rate : {0.5, 10'001.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    bad.rate_hz = rate;
    EXPECT_EQ(refusal(NodeMessage(bad)), ErrorCode::out_of_range) << rate;
  }
  bad = hello();
  bad.firmware = std::string(kMaxNodeText + 1, 'x');
  EXPECT_EQ(refusal(NodeMessage(bad)), ErrorCode::malformed);
  bad = hello();
  bad.sites[1] = "a\nb";
  EXPECT_EQ(refusal(NodeMessage(bad)), ErrorCode::malformed);
  EXPECT_EQ(refusal(NodeMessage(NodeHeartbeat{.battery_percent = 101})), ErrorCode::out_of_range);
  EXPECT_EQ(refusal(NodeMessage(NodeHeartbeat{.time = DeviceTime(Duration(-1))})), ErrorCode::out_of_range);
  EXPECT_EQ(refusal(NodeMessage(Welcome{.session = 0})), ErrorCode::malformed);
  EXPECT_EQ(refusal(NodeMessage(Welcome{.session = 1, .heartbeat = std::chrono::milliseconds(99)})),
            ErrorCode::out_of_range);
  EXPECT_EQ(refusal(NodeMessage(HeartbeatEcho{.session = 0})), ErrorCode::malformed);
  EXPECT_EQ(refusal(NodeMessage(Pulse{.edge = DeviceTime(std::chrono::hours(24 * 365 * 4))})),
            ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::imu::node_message_test
