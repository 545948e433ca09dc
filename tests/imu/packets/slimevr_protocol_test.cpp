#include "mien/imu/packets/slimevr_protocol.h"

#include <gtest/gtest.h>

#include "mien/core/random.h"
#include "mien/core/units.h"
#include "mien/imu/packets/node_protocol.h"
#include "tests/hex.h"

namespace mien::imu::slimevr_protocol_test {
namespace {

using sensor::DeviceKey;
using sensor::Inbox;
using sensor::Verdict;

constexpr std::uint64_t kMac = 0x024D49454E03;

HostTime at(int ms) {
  return HostTime(std::chrono::milliseconds(ms));
}

std::vector<std::byte> encoded(std::uint64_t number, const slimevr::TrackerMessage& message) {
  ByteWriter writer;
  EXPECT_TRUE(encode_tracker_message(number, message, writer));
  return writer.release();
}

std::vector<std::byte> bundle(std::uint64_t number, const std::vector<slimevr::TrackerMessage>& messages) {
  ByteWriter writer;
  EXPECT_TRUE(encode_tracker_bundle(number, messages, writer));
  return writer.release();
}

slimevr::Rotation rotation(const Quat& q, std::uint8_t sensor = 0) {
  return {.sensor = sensor,
          .xyzw = {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
                   static_cast<float>(q.w())}};
}

/// A server that one board has found.
class Server {
 public:
  explicit Server(std::uint32_t version = slimevr::kProtocolVersion, std::uint64_t mac = kMac,
                  sensor::Peer peer = 5)
      : peer_(peer) {
    receive(encoded(0, slimevr::Handshake{.protocol = version, .firmware = "0.5", .mac = mac}));
  }
  Verdict receive(std::span<const std::byte> datagram) {
    inbox.clear();
    now += std::chrono::milliseconds(10);
    return protocol.receive(now, peer_, datagram, inbox);
  }
  slimevr::ServerMessage reply() {
    const auto message = slimevr::parse_server_message(inbox.reply);
    EXPECT_TRUE(message);
    return message ? *message : slimevr::ServerMessage();
  }

  SlimeVrProtocol protocol;
  Inbox inbox;
  HostTime now = at(0);

 private:
  sensor::Peer peer_;
};

void expect_sample(const sensor::Reading& reading, const Quat& q_world_sensor, const Vec3& force) {
  const auto& v = reading.sample.values;
  ASSERT_EQ(reading.sample.count, 7);
  const auto d = [&](std::size_t i) { return static_cast<double>(v[i]); };
  EXPECT_LT(angle_between(Quat(d(0), d(1), d(2), d(3)), q_world_sensor), 1e-6);
  EXPECT_GE(v[0], 0);
  EXPECT_LT((Vec3(d(4), d(5), d(6)) - force).norm(), 2e-5);
}

TEST(SlimeVrProtocol, GreetsAndReadsRotations) {
  Server server;
  EXPECT_EQ(server.reply(), slimevr::ServerMessage(slimevr::Greeting{}));
  EXPECT_EQ(server.inbox.alive, (DeviceKey{kMac, 0}));
  EXPECT_EQ(server.receive(encoded(1, rotation(Quat::Identity(), 3))), Verdict::taken);
  ASSERT_EQ(server.inbox.announcements.size(), 1U);
  EXPECT_EQ(server.inbox.announcements[0].from, (DeviceKey{kMac, 3}));
  EXPECT_EQ(server.inbox.announcements[0].firmware, "0.5");
  ASSERT_EQ(server.inbox.readings.size(), 1U);
  const sensor::Reading& reading = server.inbox.readings[0];
  EXPECT_EQ(reading.from, (DeviceKey{kMac, 3}));
  EXPECT_EQ(reading.sample.kind, sensor::SampleKind::imu_fused);
  EXPECT_EQ(reading.sample.sequence, 1U);
  EXPECT_TRUE(reading.sample.time_estimated);
  EXPECT_FALSE(reading.saturated);
  EXPECT_FALSE(server.inbox.alive);
  server.receive(encoded(2, rotation(Quat::Identity(), 3)));
  EXPECT_TRUE(server.inbox.announcements.empty());
}

// Their sensor at rest with its +Z up is the identity; in our world its +Z then points along +Y.
TEST(SlimeVrProtocol, TurnsTheirWorldUpright) {
  Server server;
  server.receive(encoded(1, rotation(Quat::Identity())));
  const Quat upright(Eigen::AngleAxisd(-EIGEN_PI / 2, Vec3::UnitX()));
  expect_sample(server.inbox.readings.at(0), upright, Vec3(0, 0, kStandardGravity_m_s2));
  EXPECT_LT((upright * Vec3::UnitZ() - Vec3::UnitY()).norm(), 1e-12);
}

// What any accelerometer would read comes out of an orientation and an acceleration without gravity.
TEST(SlimeVrProtocol, PutsGravityBack) {
  Random random(3);
  Server server;
  for (std::uint64_t i = 1; i < 100; ++i) {
    const Quat q = random.rotation();  // Sensor to their world, +Z up.
    const Vec3 linear = 5 * random.direction();
    server.receive(bundle(i, {rotation(q), slimevr::Acceleration{.m_s2 = {static_cast<float>(linear.x()),
                                                                          static_cast<float>(linear.y()),
                                                                          static_cast<float>(linear.z())}}}));
    ASSERT_EQ(server.inbox.readings.size(), 1U);
    expect_sample(server.inbox.readings[0], Quat(Eigen::AngleAxisd(-EIGEN_PI / 2, Vec3::UnitX())) * q,
                  linear + q.conjugate() * Vec3(0, 0, kStandardGravity_m_s2));
  }
}

TEST(SlimeVrProtocol, PairsAnAccelerationThatComesFirst) {
  Server server;
  const slimevr::Acceleration one{.m_s2 = {1, 0, 0}};
  const slimevr::Acceleration two{.m_s2 = {2, 0, 0}, .sensor = 1};
  server.receive(bundle(1, {one, two, rotation(Quat::Identity()), rotation(Quat::Identity(), 1)}));
  ASSERT_EQ(server.inbox.readings.size(), 2U);
  EXPECT_FLOAT_EQ(server.inbox.readings[0].sample.values[4], 1);
  EXPECT_FLOAT_EQ(server.inbox.readings[1].sample.values[4], 2);
  server.receive(bundle(2, {rotation(Quat::Identity()), rotation(Quat::Identity(), 1), two, one}));
  EXPECT_FLOAT_EQ(server.inbox.readings[0].sample.values[4], 1);
  EXPECT_FLOAT_EQ(server.inbox.readings[1].sample.values[4], 2);
}

TEST(SlimeVrProtocol, UsesTheNewestAccelerationOfBoardsThatDoNotBundle) {
  Server server;
  EXPECT_EQ(server.receive(encoded(1, slimevr::Acceleration{.m_s2 = {1, 0, 0}})), Verdict::taken);
  EXPECT_TRUE(server.inbox.readings.empty());
  for (std::uint64_t i = 2; i < 10; ++i) {
    server.receive(encoded(i, rotation(Quat::Identity())));
    EXPECT_FLOAT_EQ(server.inbox.readings.at(0).sample.values[4], i < 6 ? 1 : 0) << i;  // Not for ever.
    EXPECT_FLOAT_EQ(server.inbox.readings.at(0).sample.values[6], static_cast<float>(kStandardGravity_m_s2));
  }
}

TEST(SlimeVrProtocol, TurnsTheAccelerationsOfOlderBoards) {
  for (const std::uint32_t version : {21U, 22U}) {
    Server server(version);
    server.receive(bundle(1, {rotation(Quat::Identity()), slimevr::Acceleration{.m_s2 = {1, 2, 0}}}));
    const Quat upright(Eigen::AngleAxisd(-EIGEN_PI / 2, Vec3::UnitX()));
    const Vec3 linear = version < 22 ? Vec3(2, -1, 0) : Vec3(1, 2, 0);
    expect_sample(server.inbox.readings.at(0), upright, linear + Vec3(0, 0, kStandardGravity_m_s2));
  }
}

TEST(SlimeVrProtocol, ReadsBothInOne) {
  Server server;
  server.receive(
      encoded(1, slimevr::RotationAndAcceleration{.xyzw = {0, 0, 0, 32767.0F / 32768}, .m_s2 = {1, 0, 0}}));
  expect_sample(server.inbox.readings.at(0), Quat(Eigen::AngleAxisd(-EIGEN_PI / 2, Vec3::UnitX())),
                Vec3(1, 0, kStandardGravity_m_s2));
}

TEST(SlimeVrProtocol, DropsWhatComesOutOfOrder) {
  Server server;
  const auto verdict = [&](std::uint64_t number) {
    return server.receive(encoded(number, rotation(Quat::Identity())));
  };
  EXPECT_EQ(verdict(7), Verdict::taken);
  EXPECT_EQ(verdict(7), Verdict::ignored);
  EXPECT_TRUE(server.inbox.readings.empty());
  EXPECT_FALSE(server.inbox.alive);
  EXPECT_EQ(verdict(6), Verdict::ignored);
  EXPECT_EQ(verdict(0), Verdict::taken);  // Not counted.
  EXPECT_EQ(verdict(9), Verdict::taken);
  // The board began anew.
  server.receive(encoded(0, slimevr::Handshake{.mac = kMac}));
  EXPECT_EQ(verdict(1), Verdict::taken);
}

TEST(SlimeVrProtocol, TimesNeverRunBack) {
  Server server;
  DeviceTime last = DeviceTime::min();
  for (std::uint64_t i = 1; i < 50; ++i) {
    if (i == 20) server.receive(encoded(0, slimevr::Handshake{.mac = kMac}));
    server.receive(encoded(i, rotation(Quat::Identity())));
    EXPECT_GT(server.inbox.readings.at(0).sample.time, last);
    last = server.inbox.readings[0].sample.time;
  }
}

TEST(SlimeVrProtocol, HearsNobodyWithoutAHandshake) {
  SlimeVrProtocol protocol;
  Inbox inbox;
  EXPECT_EQ(protocol.receive(at(0), 1, encoded(1, rotation(Quat::Identity())), inbox), Verdict::ignored);
  EXPECT_EQ(protocol.receive(at(0), 1, encoded(0, slimevr::Handshake{}), inbox),
            Verdict::ignored);  // No MAC.
  EXPECT_TRUE(inbox.readings.empty());
  EXPECT_TRUE(inbox.reply.empty());
  std::vector<sensor::Protocol::Outgoing> out;
  protocol.heartbeats(at(1000), out);
  EXPECT_TRUE(out.empty());  // Else a board that waits for a greeting would wait for ever.
}

TEST(SlimeVrProtocol, HearsANumberAtEveryAddressThatGivesIt) {
  Server server;
  Inbox inbox;
  server.protocol.receive(at(100), 6, encoded(0, slimevr::Handshake{.mac = kMac}), inbox);
  EXPECT_EQ(server.receive(encoded(1, rotation(Quat::Identity()))), Verdict::taken)
      << "anyone can give a number: the board at the first address stays";
  EXPECT_EQ(server.protocol.receive(at(110), 6, encoded(1, rotation(Quat::Identity())), inbox),
            Verdict::taken);
  // Another board at that address.
  server.protocol.receive(at(120), 6, encoded(0, slimevr::Handshake{.mac = 77}), inbox);
  inbox.clear();
  server.protocol.receive(at(130), 6, encoded(1, rotation(Quat::Identity())), inbox);
  EXPECT_EQ(inbox.readings.at(0).from, (DeviceKey{77, 0}));
}

TEST(SlimeVrProtocol, AnswersWhatATrackerAsks) {
  Server server;
  EXPECT_EQ(server.receive(encoded(1, slimevr::SensorInfo{.sensor = 1})), Verdict::taken);
  EXPECT_EQ(server.reply(), slimevr::ServerMessage(slimevr::SensorInfoAck{1, 1}));
  ASSERT_EQ(server.inbox.announcements.size(), 1U);
  EXPECT_EQ(server.inbox.announcements[0].from, (DeviceKey{kMac, 1}));
  EXPECT_EQ(server.receive(encoded(2, slimevr::SensorInfo{.sensor = 2, .state = 2})), Verdict::ignored);
  EXPECT_EQ(server.reply(), slimevr::ServerMessage(slimevr::SensorInfoAck{2, 2}));
  EXPECT_TRUE(server.inbox.announcements.empty());
  EXPECT_EQ(server.receive(encoded(3, slimevr::FeatureFlags{})), Verdict::ignored);
  EXPECT_EQ(server.reply(), slimevr::ServerMessage(slimevr::ServerFlags{slimevr::ServerFlags::kBundle}));
}

TEST(SlimeVrProtocol, AcknowledgesEverySensorOfABundle) {
  Server server;
  server.receive(bundle(1, {slimevr::SensorInfo{.sensor = 1}, slimevr::SensorInfo{.sensor = 2}}));
  EXPECT_EQ(server.reply(), slimevr::ServerMessage(slimevr::SensorInfoAck{1, 1}));
  std::vector<sensor::Protocol::Outgoing> out;
  server.protocol.heartbeats(at(20), out);
  ASSERT_FALSE(out.empty());
  EXPECT_EQ(*slimevr::parse_server_message(out[0].datagram),
            slimevr::ServerMessage(slimevr::SensorInfoAck{2, 1}));
}

TEST(SlimeVrProtocol, PassesTheBatteryOn) {
  Server server;
  EXPECT_EQ(server.receive(encoded(1, slimevr::Battery{.volts = 3.7F, .level = 0.456F})), Verdict::taken);
  ASSERT_EQ(server.inbox.batteries.size(), 1U);
  EXPECT_EQ(server.inbox.batteries[0].percent, 46);
  server.receive(encoded(2, slimevr::Battery{.level = 7}));
  EXPECT_EQ(server.inbox.batteries[0].percent, 100);
}

// A sensor that lies still sends nothing; its board goes on to answer.
TEST(SlimeVrProtocol, SaysThatAQuietBoardIsThere) {
  Server server;
  EXPECT_EQ(server.receive(encoded(1, slimevr::Heartbeat{})), Verdict::taken);
  EXPECT_EQ(server.inbox.alive, (DeviceKey{kMac, 0}));
  EXPECT_EQ(server.receive(encoded(0, slimevr::Pong{3})), Verdict::ignored);
  EXPECT_EQ(server.inbox.alive, (DeviceKey{kMac, 0}));
  EXPECT_EQ(server.receive(encoded(2, slimevr::Temperature{.celsius = 30})), Verdict::ignored);
  EXPECT_EQ(server.inbox.alive, (DeviceKey{kMac, 0}));
}

TEST(SlimeVrProtocol, KeepsInTouch) {
  Server server;
  std::vector<sensor::Protocol::Outgoing> out;
  int heartbeats = 0;
  int pings = 0;
  for (int ms = 0; ms < 5000; ms += 100) {
    out.clear();
    server.receive(encoded(0, slimevr::Pong{}));
    server.protocol.heartbeats(at(ms), out);
    for (const auto& outgoing : out) {
      EXPECT_EQ(outgoing.peer, 5U);
      const auto message = slimevr::parse_server_message(outgoing.datagram);
      ASSERT_TRUE(message);
      heartbeats += std::holds_alternative<slimevr::ServerHeartbeat>(*message) ? 1 : 0;
      pings += std::holds_alternative<slimevr::Ping>(*message) ? 1 : 0;
    }
  }
  EXPECT_NEAR(heartbeats, 10, 1);
  EXPECT_EQ(heartbeats, pings);
  out.clear();
  server.protocol.heartbeats(at(60'000), out);  // It has been away for long.
  EXPECT_TRUE(out.empty());
}

TEST(SlimeVrProtocol, DoesNotGrowWithStrangers) {
  SlimeVrProtocol protocol;
  Inbox inbox;
  for (sensor::Peer peer = 1; peer < 1000; ++peer)
    protocol.receive(at(0), peer, encoded(0, slimevr::Handshake{.mac = peer}), inbox);
  std::vector<sensor::Protocol::Outgoing> out;
  protocol.heartbeats(at(1), out);
  EXPECT_EQ(out.size(), 2U * 64) << "a heartbeat and a ping to each that is known";
  protocol.receive(at(1), 1, encoded(0, slimevr::Handshake{.mac = 1}), inbox);
  std::size_t readings = 0;
  for (int sensor = 0; sensor < 256; ++sensor) {
    inbox.clear();
    protocol.receive(at(0), 1,
                     encoded(static_cast<std::uint64_t>(sensor) + 1,
                             rotation(Quat::Identity(), static_cast<std::uint8_t>(sensor))),
                     inbox);
    readings += inbox.readings.size();
  }
  EXPECT_EQ(readings, 32U);
}

TEST(SlimeVrProtocol, StrangersKeepNoBoardOut) {
  SlimeVrProtocol protocol;
  Inbox inbox;
  for (sensor::Peer peer = 100; peer < 400; ++peer)
    protocol.receive(at(0), peer, encoded(0, slimevr::Handshake{.mac = peer}), inbox);
  protocol.receive(at(1), 1, encoded(0, slimevr::Handshake{.mac = kMac}), inbox);
  protocol.receive(at(1), 1, encoded(1, rotation(Quat::Identity())), inbox);
  // They go on; who sends rotations stays.
  for (sensor::Peer peer = 400; peer < 700; ++peer)
    protocol.receive(at(2), peer, encoded(0, slimevr::Handshake{.mac = peer}), inbox);
  inbox.clear();
  EXPECT_EQ(protocol.receive(at(3), 1, encoded(2, rotation(Quat::Identity())), inbox), Verdict::taken);
  EXPECT_EQ(inbox.readings.size(), 1U);
}

TEST(SlimeVrProtocol, TakesNothingFromBrokenPackets) {
  Server server;
  EXPECT_EQ(server.receive(bytes_of("000000110000000000000001")), Verdict::malformed);
  EXPECT_EQ(server.receive(encoded(1, slimevr::Rotation{})), Verdict::malformed);
  EXPECT_TRUE(server.inbox.readings.empty());
  EXPECT_FALSE(server.inbox.alive);
  EXPECT_EQ(server.receive(encoded(1, rotation(Quat::Identity()))), Verdict::taken);  // It used up no number.
}

// Two languages on one port.
TEST(SlimeVrProtocol, IsNotTakenForOurs) {
  const auto ours = NodeProtocol::create();
  ASSERT_TRUE(ours);
  const SlimeVrProtocol theirs;
  ByteWriter hello;
  ASSERT_TRUE(encode_node_message(Hello{.sites = {""}}, hello));
  for (const auto& datagram : {encoded(0, slimevr::Handshake{}), encoded(1, rotation(Quat::Identity())),
                               bundle(2, {slimevr::Heartbeat{}})}) {
    EXPECT_TRUE(theirs.recognises(datagram));
    EXPECT_FALSE(ours->recognises(datagram));
  }
  EXPECT_TRUE(ours->recognises(hello.bytes()));
  EXPECT_FALSE(theirs.recognises(hello.bytes()));
  const auto osc = bytes_of("2f696d752f30000000000000");  // Something else altogether.
  EXPECT_FALSE(theirs.recognises(osc));
  EXPECT_FALSE(ours->recognises(osc));
}

}  // namespace
}  // namespace mien::imu::slimevr_protocol_test
