#include "mien/imu/packets/node_protocol.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "mien/imu/packets/packet.h"
#include "mien/sensor/sealed_protocol.h"
#include "tests/hex.h"

namespace mien::imu::node_protocol_test {
namespace {

using sensor::DeviceKey;
using sensor::Inbox;
using sensor::Verdict;

constexpr std::uint64_t kDevice = 0x024D49454E07;
constexpr std::uint64_t kSession = 0x1122334455667788;

sensor::SealKey key(std::uint8_t id) {
  sensor::SealKey k{.id = id};
  for (std::size_t i = 0; i < k.secret.size(); ++i) k.secret[i] = static_cast<std::byte>(i + id);
  return k;
}

NodeProtocol protocol() {
  auto made = NodeProtocol::create({.host_name = "studio", .session = kSession});
  EXPECT_TRUE(made) << made.error().message();
  return std::move(*made);
}

sensor::SealedProtocol sealed(std::vector<sensor::SealKey> keys) {
  std::vector<std::unique_ptr<sensor::Protocol>> languages;
  languages.push_back(std::make_unique<NodeProtocol>(protocol()));
  auto made = sensor::SealedProtocol::create(kSession, std::move(keys), std::move(languages));
  EXPECT_TRUE(made) << made.error().message();
  return std::move(*made);
}

std::vector<std::byte> encoded(const NodeMessage& message) {
  ByteWriter writer;
  EXPECT_TRUE(encode_node_message(message, writer));
  return writer.release();
}

std::vector<std::byte> samples_packet() {
  Packet p;
  p.device = kDevice;
  p.channel = 1;
  p.sequence = 7;
  p.battery_percent = 55;
  p.time = DeviceTime(std::chrono::milliseconds(20));
  p.interval = std::chrono::milliseconds(4);
  p.count = 3;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 6; ++k) p.values[i][k] = 0.25F;
  p.values[1][5] = 1000;   // Beyond what the chip can say: it stands at the end of its range.
  p.values[2][0] = -1000;  // And at the other.
  auto bytes = encode_packet(p);
  EXPECT_TRUE(bytes);
  return *bytes;
}

struct Received {
  Verdict verdict;
  Inbox inbox;
};

Received receive(sensor::Protocol& protocol, std::span<const std::byte> datagram) {
  Received received;
  received.verdict = protocol.receive(HostTime(std::chrono::seconds(1)), 3, datagram, received.inbox);
  return received;
}

NodeMessage reply_of(const Received& received) {
  const auto message = parse_node_message(received.inbox.reply);
  EXPECT_TRUE(message) << message.error().message();
  return message ? *message : NodeMessage();
}

bool says_nothing(const Inbox& inbox) {
  return inbox.readings.empty() && inbox.announcements.empty() && inbox.batteries.empty() &&
         inbox.pulses.empty() && !inbox.alive && inbox.reply.empty() && inbox.opened.empty();
}

TEST(NodeProtocol, WelcomesWhoSaysHello) {
  NodeProtocol host = protocol();
  const auto received =
      receive(host, encoded(Hello{.device = kDevice, .firmware = "0.1.0", .sites = {"mentalis", ""}}));
  EXPECT_EQ(received.verdict, Verdict::taken);
  ASSERT_EQ(received.inbox.announcements.size(), 2U);
  EXPECT_EQ(received.inbox.announcements[0].from, (DeviceKey{kDevice, 0}));
  EXPECT_EQ(received.inbox.announcements[0].site, "mentalis");
  EXPECT_EQ(received.inbox.announcements[0].firmware, "0.1.0");
  EXPECT_EQ(received.inbox.announcements[1].from, (DeviceKey{kDevice, 1}));
  EXPECT_EQ(received.inbox.announcements[1].site, "");
  EXPECT_EQ(reply_of(received), NodeMessage(Welcome{.device = kDevice,
                                                    .session = kSession,
                                                    .heartbeat = std::chrono::milliseconds(500),
                                                    .host = "studio"}));
}

TEST(NodeProtocol, EchoesHeartbeats) {
  NodeProtocol host = protocol();
  const DeviceTime now(std::chrono::microseconds(123'456));
  auto received =
      receive(host, encoded(NodeHeartbeat{.device = kDevice, .battery_percent = 40, .time = now}));
  EXPECT_EQ(received.verdict, Verdict::taken);
  EXPECT_EQ(received.inbox.alive, (DeviceKey{kDevice, 0}));
  ASSERT_EQ(received.inbox.batteries.size(), 1U);
  EXPECT_EQ(received.inbox.batteries[0].percent, 40);
  EXPECT_EQ(reply_of(received), NodeMessage(HeartbeatEcho{kDevice, now, kSession}));
  received = receive(host, encoded(NodeHeartbeat{.device = kDevice, .time = now}));
  EXPECT_TRUE(received.inbox.batteries.empty());
}

TEST(NodeProtocol, ReadsSamplesAndWhatTheirRangesHide) {
  NodeProtocol host = protocol();
  const auto received = receive(host, samples_packet());
  EXPECT_EQ(received.verdict, Verdict::taken);
  ASSERT_EQ(received.inbox.readings.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const sensor::Reading& reading = received.inbox.readings[i];
    EXPECT_EQ(reading.from, (DeviceKey{kDevice, 1}));
    EXPECT_EQ(reading.sample.kind, sensor::SampleKind::imu_raw);
    EXPECT_EQ(reading.sample.sequence, 7U);
    EXPECT_EQ(reading.sample.count, 6);
    EXPECT_FALSE(reading.sample.time_estimated);
    EXPECT_EQ(reading.sample.time, DeviceTime(std::chrono::milliseconds(20 + 4 * static_cast<int>(i))));
    EXPECT_EQ(reading.saturated, i > 0) << i;
  }
  ASSERT_EQ(received.inbox.batteries.size(), 1U);
  EXPECT_EQ(received.inbox.batteries[0].percent, 55);
  EXPECT_TRUE(received.inbox.reply.empty());
}

TEST(NodeProtocol, ReadsPulses) {
  NodeProtocol host = protocol();
  const DeviceTime edge(std::chrono::microseconds(5'000'001));
  const auto received = receive(host, encoded(Pulse{.device = kDevice, .index = 9, .edge = edge}));
  EXPECT_EQ(received.verdict, Verdict::taken);
  ASSERT_EQ(received.inbox.pulses.size(), 1U);
  EXPECT_EQ(received.inbox.pulses[0].from, (DeviceKey{kDevice, 0}));
  EXPECT_EQ(received.inbox.pulses[0].index, 9U);
  EXPECT_EQ(received.inbox.pulses[0].edge, edge);
}

TEST(NodeProtocol, TellsItsLanguageByItsFirstBytes) {
  const NodeProtocol host = protocol();
  EXPECT_TRUE(host.recognises(samples_packet()));
  EXPECT_TRUE(host.recognises(bytes_of("4d49454eff99")));
  EXPECT_FALSE(host.recognises(bytes_of("4d49454e01")));
  EXPECT_FALSE(host.recognises(bytes_of("000000110000000000000001")));
  EXPECT_FALSE(host.recognises({}));
}

TEST(NodeProtocol, LeavesOtherHostsAndLaterVersionsAlone) {
  NodeProtocol host = protocol();
  for (auto bytes : {encoded(Welcome{.session = 5}), encoded(HeartbeatEcho{.session = 5})}) {
    const auto received = receive(host, bytes);
    EXPECT_EQ(received.verdict, Verdict::ignored);
    EXPECT_TRUE(says_nothing(received.inbox));
  }
  auto later = encoded(Pulse{});
  later[4] = std::byte{2};
  EXPECT_EQ(receive(host, later).verdict, Verdict::refused);
  auto unknown = encoded(Pulse{});
  unknown[5] = std::byte{99};
  renew_checksum(unknown);
  EXPECT_EQ(receive(host, unknown).verdict, Verdict::refused);
}

TEST(NodeProtocol, TakesNothingFromBrokenPackets) {
  NodeProtocol host = protocol();
  for (auto bytes : {samples_packet(), encoded(Hello{.sites = {""}}), encoded(NodeHeartbeat{})}) {
    bytes.back() ^= std::byte{1};
    const auto received = receive(host, bytes);
    EXPECT_EQ(received.verdict, Verdict::malformed);
    EXPECT_TRUE(says_nothing(received.inbox));
  }
}

TEST(NodeProtocol, IsNotMadeOfSettingsThatCannotBe) {
  EXPECT_FALSE(NodeProtocol::create({.session = 0}));
  EXPECT_FALSE(NodeProtocol::create({.host_name = "a\nb"}));
  EXPECT_FALSE(NodeProtocol::create({.heartbeat = std::chrono::milliseconds(50)}));
}

// With keys.

struct Node {
  sensor::SealKey with = key(1);
  std::uint64_t counter = 5;
  std::uint64_t session = kSession;
  std::uint64_t device = kDevice;

  std::vector<std::byte> seal(std::span<const std::byte> inner) {
    ByteWriter writer;
    EXPECT_TRUE(sensor::seal_packet(
        with, {.key_id = with.id, .device = device, .counter = counter++, .session = session}, inner,
        writer));
    return writer.release();
  }
};

TEST(SealedNodes, AreHeardAndAnsweredAlike) {
  sensor::SealedProtocol host = sealed({key(4), key(1)});
  Node node{.session = 0};
  const auto plain = encoded(Hello{.device = kDevice, .sites = {"mentalis"}});
  auto received = receive(host, node.seal(plain));
  EXPECT_EQ(received.verdict, Verdict::taken);
  EXPECT_EQ(received.inbox.opened, plain);
  EXPECT_EQ(received.inbox.announcements.size(), 1U);
  std::vector<std::byte> inner;
  auto header = sensor::open_sealed(std::vector{key(1)}, received.inbox.reply, inner);
  ASSERT_TRUE(header) << header.error().message();
  EXPECT_EQ(
      *header,
      (sensor::SealHeader{
          .key_id = 1, .device = kDevice, .counter = sensor::SealHeader::kFromHost, .session = kSession}));
  const auto welcome = parse_node_message(inner);
  ASSERT_TRUE(welcome);
  node.session = std::get<Welcome>(*welcome).session;

  received = receive(host, node.seal(samples_packet()));
  EXPECT_EQ(received.verdict, Verdict::taken);
  EXPECT_EQ(received.inbox.readings.size(), 3U);
  received = receive(host, node.seal(encoded(NodeHeartbeat{.device = kDevice})));
  header = sensor::open_sealed(std::vector{key(1)}, received.inbox.reply, inner);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->counter, sensor::SealHeader::kFromHost + 1);  // No counter comes twice.

  // What was logged replays without keys.
  NodeProtocol replay = protocol();
  EXPECT_EQ(receive(replay, plain).inbox.announcements.size(), 1U);
}

void expect_refused(sensor::Protocol& host, std::span<const std::byte> bytes) {
  const auto received = receive(host, bytes);
  EXPECT_EQ(received.verdict, Verdict::refused);
  EXPECT_TRUE(says_nothing(received.inbox));
}

TEST(SealedNodes, RefuseWhatIsNotSealed) {
  sensor::SealedProtocol host = sealed({key(1)});
  expect_refused(host, samples_packet());
  expect_refused(host, encoded(Hello{.sites = {""}}));
}

TEST(SealedNodes, AreRefusedByAHostWithoutKeys) {
  NodeProtocol host = protocol();
  expect_refused(host, Node().seal(samples_packet()));
}

TEST(SealedNodes, RefuseAnUnknownAndAWrongKey) {
  sensor::SealedProtocol host = sealed({key(1)});
  expect_refused(host, Node{.with = key(2)}.seal(samples_packet()));
  sensor::SealKey wrong = key(1);
  wrong.secret[31] ^= std::byte{1};
  expect_refused(host, Node{.with = wrong}.seal(samples_packet()));
}

TEST(SealedNodes, RefuseEveryChangedByte) {
  sensor::SealedProtocol host = sealed({key(1)});
  const auto whole = Node().seal(encoded(Pulse{.device = kDevice}));
  for (std::size_t i = 8; i + 4 < whole.size(); ++i) {
    auto changed = whole;
    changed[i] ^= std::byte{0x20};
    EXPECT_EQ(receive(host, changed).verdict, Verdict::malformed) << i;  // The radio may do that.
    renew_checksum(changed);
    expect_refused(host, changed);
  }
  EXPECT_EQ(receive(host, whole).verdict, Verdict::taken);
}

TEST(SealedNodes, RefuseEveryLengthButItsOwn) {
  sensor::SealedProtocol host = sealed({key(1)});
  const auto whole = Node().seal(encoded(Pulse{.device = kDevice}));
  for (std::size_t size = 8; size < whole.size(); ++size) {
    std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    renew_checksum(cut);
    EXPECT_NE(receive(host, cut).verdict, Verdict::taken) << size;
  }
}

TEST(SealedNodes, RefuseRepeatedAndOldCounters) {
  sensor::SealedProtocol host = sealed({key(1)});
  const auto at = [&](std::uint64_t counter) {
    return receive(host, Node{.counter = counter}.seal(encoded(Pulse{.device = kDevice}))).verdict;
  };
  EXPECT_EQ(at(100), Verdict::taken);
  EXPECT_EQ(at(100), Verdict::refused);
  EXPECT_EQ(at(98), Verdict::taken);  // Overtaken on its way.
  EXPECT_EQ(at(98), Verdict::refused);
  EXPECT_EQ(at(37), Verdict::taken);  // 63 behind.
  EXPECT_EQ(at(36), Verdict::refused);
  EXPECT_EQ(at(std::uint64_t{1} << 32U), Verdict::taken);  // The node was switched off and on.
  EXPECT_EQ(at(101), Verdict::refused);
  EXPECT_EQ(at(sensor::SealHeader::kFromHost | 7), Verdict::refused);  // Our own words, sent back to us.
  // Each device counts for itself.
  EXPECT_EQ(receive(host, Node{.counter = 1, .device = 8}.seal(encoded(Pulse{.device = 8}))).verdict,
            Verdict::taken);
}

TEST(SealedNodes, RefuseAnotherSessionsPackets) {
  sensor::SealedProtocol host = sealed({key(1)});
  expect_refused(host, Node{.session = 77}.seal(samples_packet()));
  expect_refused(host, Node{.session = 0}.seal(samples_packet()));
}

TEST(SealedNodes, RefuseAnotherDevicesPacketInside) {
  sensor::SealedProtocol host = sealed({key(1)});
  expect_refused(host, Node{.device = 8}.seal(samples_packet()));
}

TEST(SealedNodes, TakeNothingFromABrokenPacketInside) {
  sensor::SealedProtocol host = sealed({key(1)});
  auto broken = samples_packet();
  broken.back() ^= std::byte{1};
  const auto received = receive(host, Node().seal(broken));
  EXPECT_EQ(received.verdict, Verdict::malformed);
  EXPECT_TRUE(says_nothing(received.inbox));
}

}  // namespace
}  // namespace mien::imu::node_protocol_test
