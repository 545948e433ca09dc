#include "mien/imu/packets/slimevr.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/hex.h"

namespace mien::imu::slimevr::slimevr_test {
namespace {

const char* const kHandshakeHex =
    "00000003 0000000000000000 00000004 00000000 00000002 00000000 00000000 00000000 00000016 05302e312e30 "
    "020000000001 00 0000000000";
const char* const kRotationHex = "00000011 0000000000000001 00 01 00000000 00000000 00000000 3f800000 00";
const char* const kAccelerationHex = "00000004 0000000000000002 00000000 00000000 411ce80a 00";
const char* const kBundleHex =
    "00000064 0000000000000003 0017 00000011 000100000000000000000000 00003f80000000 "
    "0011 00000004 0000000000000000411ce80a00";

const Handshake kHandshake{.firmware = "0.1.0", .mac = 0x020000000001};
const Rotation kRotation{.xyzw = {0, 0, 0, 1}};
const Acceleration kAcceleration{.m_s2 = {0, 0, 9.80665F}};

struct Parsed {
  Header header;
  std::vector<TrackerMessage> messages;
};

Parsed parsed(std::span<const std::byte> bytes) {
  Parsed p;
  const auto header = parse_tracker_datagram(bytes, p.messages);
  EXPECT_TRUE(header) << header.error().message();
  if (header) p.header = *header;
  return p;
}

ErrorCode refusal(std::span<const std::byte> bytes) {
  std::vector<TrackerMessage> messages(2);
  const auto header = parse_tracker_datagram(bytes, messages);
  EXPECT_FALSE(header) << hex(bytes);
  EXPECT_EQ(messages.size(), 2U);
  return header ? ErrorCode::internal : header.error().code;
}

std::vector<std::byte> encoded(std::uint64_t number, const TrackerMessage& message) {
  ByteWriter writer;
  EXPECT_TRUE(encode_tracker_message(number, message, writer));
  return writer.release();
}

std::vector<std::byte> encoded(const ServerMessage& message) {
  ByteWriter writer;
  encode_server_message(message, writer);
  return writer.release();
}

// The vectors of docs/reference/slimevr.md.
TEST(SlimeVr, MatchesTheDocumentsBytes) {
  EXPECT_EQ(encoded(0, kHandshake), bytes_of(kHandshakeHex));
  EXPECT_EQ(encoded(1, kRotation), bytes_of(kRotationHex));
  EXPECT_EQ(encoded(2, kAcceleration), bytes_of(kAccelerationHex));
  ByteWriter writer;
  ASSERT_TRUE(encode_tracker_bundle(3, std::vector<TrackerMessage>{kRotation, kAcceleration}, writer));
  EXPECT_EQ(hex(writer.bytes()), hex(bytes_of(kBundleHex)));

  auto p = parsed(bytes_of(kHandshakeHex));
  EXPECT_EQ(p.header.type, 3U);
  EXPECT_EQ(p.messages, (std::vector<TrackerMessage>{kHandshake}));
  p = parsed(bytes_of(kRotationHex));
  EXPECT_EQ(p.header.number, 1U);
  EXPECT_EQ(p.messages, (std::vector<TrackerMessage>{kRotation}));
  p = parsed(bytes_of(kAccelerationHex));
  EXPECT_EQ(p.header.number, 2U);
  EXPECT_EQ(p.messages, (std::vector<TrackerMessage>{kAcceleration}));
  p = parsed(bytes_of(kBundleHex));
  EXPECT_EQ(p.header.number, 3U);
  EXPECT_EQ(p.messages, (std::vector<TrackerMessage>{kRotation, kAcceleration}));

  auto greeting = encoded(Greeting{});
  EXPECT_EQ(hex(greeting), "03486579204f5652203d442035" + std::string(102, '0'));
  EXPECT_EQ(hex(encoded(ServerHeartbeat{})), "000000010000000000000000");
  EXPECT_EQ(hex(encoded(Ping{258})), "0000000a000000000000000000000102");
  EXPECT_EQ(hex(encoded(ServerFlags{ServerFlags::kBundle})), "00000016000000000000000001");
  EXPECT_EQ(hex(encoded(SensorInfoAck{2, 1})), "0000000f0201");
  EXPECT_TRUE(encoded(Unknown{7}).empty());
}

const std::vector<TrackerMessage>& every_message() {
  static const std::vector<TrackerMessage> messages = {
      Heartbeat{},
      kAcceleration,
      Battery{.volts = 3.7F, .level = 0.5F},
      Tap{.sensor = 1, .value = 2},
      SensorError{.sensor = 1, .code = 9},
      SensorInfo{.sensor = 1, .state = 2, .imu = 13, .config = 0x102, .calibrated = 1, .position = 1},
      Rotation{.sensor = 3, .data_type = 2, .xyzw = {0.5F, -0.5F, 0.5F, -0.5F}, .accuracy = 7},
      MagnetometerAccuracy{.sensor = 1, .accuracy = 0.25F},
      SignalStrength{.sensor = 255, .dbm = -60},
      Temperature{.sensor = 1, .celsius = 36.5F},
      UserAction{.action = 2},
      FeatureFlags{.bits = 0x80000006},
      RotationAndAcceleration{.sensor = 2, .xyzw = {0, -1, 0, 0}, .m_s2 = {1.5F, -200, 0}},
      ConfigAck{.sensor = 1, .what = 0x102}};
  return messages;
}

TEST(SlimeVr, ComesBackAsItWent) {
  for (const TrackerMessage& message : every_message()) {
    const auto bytes = encoded(77, message);
    EXPECT_TRUE(is_tracker_datagram(bytes));
    const auto p = parsed(bytes);
    EXPECT_EQ(p.header.number, 77U);
    EXPECT_EQ(p.messages, std::vector<TrackerMessage>{message});
  }
  ByteWriter writer;
  ASSERT_TRUE(encode_tracker_bundle(78, every_message(), writer));
  EXPECT_EQ(parsed(writer.bytes()).messages, every_message());
  const auto pong = parsed(encoded(5, Pong{9}));
  EXPECT_EQ(pong.header.number, 0U);
  EXPECT_EQ(pong.messages, (std::vector<TrackerMessage>{Pong{9}}));
}

TEST(SlimeVr, ReadsTheCompactBundle) {
  const auto p =
      parsed(bytes_of("00000065 0000000000000004"
                      "10 17 02 0000 0000 0000 7fff 0080 ff80 0001"
                      "09 0c 40600000 3f000000"));
  EXPECT_EQ(p.messages,
            (std::vector<TrackerMessage>{
                RotationAndAcceleration{
                    .sensor = 2, .xyzw = {0, 0, 0, 32767.0F / 32768}, .m_s2 = {1, -1, 1 / 128.0F}},
                Battery{.volts = 3.5F, .level = 0.5F}}));
}

TEST(SlimeVr, ReadsWhatOlderFirmwareSends) {
  // Rotations of one type a sensor.
  EXPECT_EQ(parsed(bytes_of("00000001 0000000000000001 00000000 00000000 00000000 3f800000")).messages,
            (std::vector<TrackerMessage>{Rotation{.sensor = 0, .xyzw = {0, 0, 0, 1}}}));
  EXPECT_EQ(parsed(bytes_of("00000010 0000000000000001 00000000 00000000 00000000 3f800000")).messages,
            (std::vector<TrackerMessage>{Rotation{.sensor = 1, .xyzw = {0, 0, 0, 1}}}));
  // A battery's level alone; a sensor's number and state alone; an acceleration without its sensor.
  EXPECT_EQ(parsed(bytes_of("0000000c 0000000000000001 3f000000")).messages,
            (std::vector<TrackerMessage>{Battery{.level = 0.5F}}));
  EXPECT_EQ(parsed(bytes_of("0000000f 0000000000000001 03 01")).messages,
            (std::vector<TrackerMessage>{SensorInfo{.sensor = 3}}));
  EXPECT_EQ(parsed(bytes_of("00000004 0000000000000001 00000000 00000000 3f800000")).messages,
            (std::vector<TrackerMessage>{Acceleration{.m_s2 = {0, 0, 1}}}));
  // Handshakes that end early, and a firmware's name that counts its end mark.
  EXPECT_EQ(std::get<Handshake>(parsed(bytes_of("00000003 0000000000000000")).messages[0]).mac, 0U);
  const auto cut = parsed(bytes_of("00000003 0000000000000000 00000004 00000000 00000002"));
  EXPECT_EQ(std::get<Handshake>(cut.messages[0]).mcu, 2U);
  const auto marked = parsed(
      bytes_of("00000003 0000000000000000 00000004 00000000 00000002 00000000 00000000 00000000 00000008"
               "04 312e0700 020000000001"));
  EXPECT_EQ(std::get<Handshake>(marked.messages[0]),
            (Handshake{.protocol = 8, .firmware = "1.?", .mac = 0x020000000001}));
}

TEST(SlimeVr, SkipsWhatItDoesNotKnow) {
  EXPECT_EQ(parsed(bytes_of("0000001a 0000000000000001 00 3f800000")).messages,
            (std::vector<TrackerMessage>{Unknown{26}}));
  EXPECT_EQ(parsed(bytes_of("00000064 0000000000000001 0005 000000ff 00 0004 00000000")).messages,
            (std::vector<TrackerMessage>{Unknown{255}, Heartbeat{}}));
  // A later firmware's further fields.
  auto longer = bytes_of(kRotationHex);
  longer.push_back(std::byte{9});
  EXPECT_EQ(parsed(longer).messages, (std::vector<TrackerMessage>{kRotation}));
}

TEST(SlimeVr, RefusesMessagesThatAreCutShort) {
  for (const TrackerMessage& message : every_message()) {
    const auto whole = encoded(1, message);
    if (std::holds_alternative<Heartbeat>(message) || std::holds_alternative<FeatureFlags>(message) ||
        std::holds_alternative<SensorInfo>(message) || std::holds_alternative<Battery>(message))
      continue;  // Their ends may be left away.
    const bool has_optional_byte =
        std::holds_alternative<Rotation>(message) || std::holds_alternative<Acceleration>(message);
    for (std::size_t size = 0; size + (has_optional_byte ? 1 : 0) < whole.size(); ++size)
      EXPECT_EQ(refusal(std::span(whole).first(size)), ErrorCode::truncated)
          << message.index() << " " << size;
  }
  EXPECT_EQ(refusal(bytes_of("0000000f 0000000000000001 03")), ErrorCode::truncated);
  EXPECT_EQ(refusal(bytes_of("0000000c 0000000000000001 3f0000")), ErrorCode::truncated);
  EXPECT_EQ(refusal(bytes_of("0000000c 0000000000000001 3f000000 3f")), ErrorCode::truncated);
}

TEST(SlimeVr, RefusesBundlesThatDoNotAddUp) {
  const auto whole = bytes_of(kBundleHex);
  for (const std::size_t size : {13U, 14U, 20U, 36U, 38U, 39U, 55U})
    EXPECT_EQ(refusal(std::span(whole).first(size)), ErrorCode::truncated) << size;
  EXPECT_EQ(refusal(bytes_of("00000064 0000000000000001 0000")), ErrorCode::malformed);
  EXPECT_EQ(refusal(bytes_of("00000064 0000000000000001 0003 000000")), ErrorCode::malformed);
  EXPECT_EQ(refusal(bytes_of("00000065 0000000000000001 00")), ErrorCode::malformed);
  EXPECT_EQ(refusal(bytes_of("00000064 0000000000000001 0004 00000064")), ErrorCode::malformed);
  EXPECT_EQ(refusal(bytes_of("00000064 0000000000000001 0004 00000065")), ErrorCode::malformed);
  EXPECT_EQ(refusal(bytes_of("00000065 0000000000000001 01 64")), ErrorCode::malformed);
  // A good message before a bad one goes with it.
  EXPECT_EQ(refusal(bytes_of("00000064 0000000000000001 0004 00000000 0004 0000000a")), ErrorCode::truncated);
}

TEST(SlimeVr, RefusesNumbersThatCannotBe) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  for (const TrackerMessage& message : std::initializer_list<TrackerMessage>{
           Rotation{.xyzw = {nan, 0, 0, 1}}, Rotation{.xyzw = {inf, 0, 0, 1}},
           Acceleration{.m_s2 = {0, nan, 0}}, Acceleration{.m_s2 = {0, 0, 1001}},
           Acceleration{.m_s2 = {0, 0, -inf}}, Battery{.volts = nan}, Battery{.level = inf},
           Temperature{.celsius = nan}, MagnetometerAccuracy{.accuracy = nan}})
    EXPECT_EQ(refusal(encoded(1, message)), ErrorCode::out_of_range) << message.index();
  for (const TrackerMessage& message : std::initializer_list<TrackerMessage>{
           Rotation{.xyzw = {0, 0, 0, 0}}, Rotation{.xyzw = {0, 0, 0, 1.02F}}, Rotation{.xyzw = {1, 0, 0, 1}},
           RotationAndAcceleration{}})
    EXPECT_EQ(refusal(encoded(1, message)), ErrorCode::malformed) << message.index();
  EXPECT_EQ(refusal(std::vector<std::byte>(kMaxDatagram + 1)), ErrorCode::malformed);
}

TEST(SlimeVr, WritesNothingThatItWouldNotRead) {
  ByteWriter writer;
  EXPECT_FALSE(encode_tracker_message(1, Unknown{}, writer));
  EXPECT_FALSE(encode_tracker_message(1, Handshake{.firmware = std::string(256, 'x')}, writer));
  EXPECT_FALSE(encode_tracker_bundle(1, {}, writer));
  EXPECT_FALSE(encode_tracker_bundle(1, std::vector<TrackerMessage>{kHandshake}, writer));
  EXPECT_FALSE(encode_tracker_bundle(1, std::vector<TrackerMessage>{Unknown{}}, writer));
  EXPECT_FALSE(encode_tracker_bundle(1, std::vector<TrackerMessage>(100, kRotation), writer));
  EXPECT_TRUE(writer.bytes().empty());
}

TEST(SlimeVr, KnowsATrackersDatagramWhenItSeesOne) {
  for (const char* const text : {kHandshakeHex, kRotationHex, kAccelerationHex, kBundleHex})
    EXPECT_TRUE(is_tracker_datagram(bytes_of(text)));
  EXPECT_FALSE(is_tracker_datagram({}));
  EXPECT_FALSE(is_tracker_datagram(bytes_of("0000000000000000000000")));                // 11 bytes
  EXPECT_FALSE(is_tracker_datagram(bytes_of("000001000000000000000001")));              // Type 256.
  EXPECT_FALSE(is_tracker_datagram(bytes_of("000000110000000000000001000100000000")));  // Too short for it.
  EXPECT_FALSE(is_tracker_datagram(bytes_of("000000030000000000000001")));          // A counted handshake.
  EXPECT_FALSE(is_tracker_datagram(bytes_of("4d49454e01010100074e45494d020000")));  // Ours.
  EXPECT_FALSE(is_tracker_datagram(std::vector<std::byte>(kMaxDatagram + 1)));
}

TEST(SlimeVr, ServersWordsComeBackAsTheyWent) {
  for (const ServerMessage& message : std::initializer_list<ServerMessage>{
           Greeting{}, ServerHeartbeat{}, Ping{7}, ServerFlags{3}, SensorInfoAck{1, 2}}) {
    const auto bytes = encoded(message);
    const auto back = parse_server_message(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(*back, message);
  }
  for (const char* const text : {"", "03486579", "0000000f02", "00000001", "0000000a00000000000000000000ff"})
    EXPECT_FALSE(parse_server_message(bytes_of(text))) << text;
  EXPECT_FALSE(parse_server_message(bytes_of("03486579204f5652203d442036")));
  const auto config = parse_server_message(bytes_of("00000019 0000000000000000 00 0001 01"));
  ASSERT_TRUE(config);
  EXPECT_EQ(*config, ServerMessage(Unknown{25}));
}

}  // namespace
}  // namespace mien::imu::slimevr::slimevr_test
