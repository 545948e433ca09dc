// A virtual node that speaks our own packets: what it says when, to whomever listens.
#include "mien/virtual/imu/mien_node.h"

#include <gmock/gmock.h>

#include "mien/imu/packets/node_protocol.h"
#include "mien/sensor/bindings.h"
#include "mien/virtual/imu/imu_simulator.h"
#include "tests/virtual/conversation.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::mien_node_test {
namespace {

using test::at;
using test::Conversation;
using ::testing::Each;

imu::NodeProtocol host(std::uint64_t session = 7) {
  return imu::NodeProtocol::create({.session = session}).value();
}

std::size_t count(const std::vector<Conversation::Sent>& sent, imu::NodePacketType type) {
  std::size_t count = 0;
  for (const Conversation::Sent& s : sent) count += s.bytes[5] == static_cast<std::byte>(type) ? 1 : 0;
  return count;
}

/// Sensor 1 of three, and the three seconds that it samples.
class MienNodeTest : public ::testing::Test {
 protected:
  explicit MienNodeTest(double packet_loss = 0) {
    faults_.packet_loss = packet_loss;
    ImuSimulator simulator(faults_, 1, Random(4));
    const face::Motion motion = test::talking(181);
    const auto sites = test::three_sites();
    packets_ = simulator.play(trace_skin(face::MotionCurve(motion), sites, -0.25, 3));
    clock_ = simulator.clock();
    node_.emplace(1, "buccinator_L", clock_, faults_);
  }

  DeviceFaults faults_ = test::mild_faults();
  std::vector<VirtualPacket> packets_;
  VirtualClock clock_;
  std::optional<MienNode> node_;
};

TEST_F(MienNodeTest, SaysHelloWithItsSiteUntilItIsWelcomed) {
  Conversation alone(*node_, nullptr);
  alone.run_until(at(4.5));
  ASSERT_EQ(alone.sent().size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(alone.sent()[i].time, at(static_cast<double>(i)));
    const auto hello = std::get<imu::Hello>(imu::parse_node_message(alone.sent()[i].bytes).value());
    EXPECT_EQ(hello.device, 0x024D'4945'4E01U);
    EXPECT_EQ(hello.rate_hz, 240);
    EXPECT_THAT(hello.sites, ::testing::ElementsAre("buccinator_L"));
  }
  EXPECT_FALSE(node_->answered());
  imu::NodeProtocol live = host();
  alone.connect(&live);
  alone.run_until(at(9.5));
  EXPECT_EQ(alone.sent().size(), 6U);
  EXPECT_TRUE(node_->answered());
  ASSERT_EQ(alone.inbox().announcements.size(), 1U);
  EXPECT_EQ(alone.inbox().announcements[0].site, "buccinator_L");
}

TEST_F(MienNodeTest, SendsEverySampleWhenItWouldArrive) {
  imu::NodeProtocol live = host();
  Conversation talk(*node_, &live);
  talk.run_until(at(0.5));
  node_->begin(at(1));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(4.5));
  EXPECT_TRUE(node_->idle());
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::taken));
  EXPECT_EQ(talk.inbox().readings.size(), 4 * packets_.size());
  std::vector<std::pair<HostTime, std::vector<std::byte>>> expected;
  for (const VirtualPacket& packet : packets_)
    expected.emplace_back(packet.arrival + std::chrono::seconds(1),
                          encode_device_packet(packet, {sensor::virtual_device(1), 0}, faults_).value());
  std::ranges::stable_sort(expected, {}, [](const auto& e) { return e.first; });
  std::size_t next = 0;
  for (const Conversation::Sent& sent : talk.sent()) {
    if (sent.bytes[5] != std::byte{1}) continue;
    ASSERT_LT(next, expected.size());
    EXPECT_EQ(sent.time, expected[next].first);
    EXPECT_EQ(sent.bytes, expected[next].second);
    ++next;
  }
  EXPECT_EQ(next, expected.size());
}

TEST_F(MienNodeTest, StreamsToWhomeverDoesNotAnswer) {
  Conversation alone(*node_, nullptr);
  node_->begin(at(1));
  ASSERT_TRUE(node_->play(packets_));
  alone.run_until(at(4.5));
  EXPECT_EQ(count(alone.sent(), imu::NodePacketType::samples), packets_.size());
  EXPECT_EQ(count(alone.sent(), imu::NodePacketType::hello), 5U);
  EXPECT_EQ(count(alone.sent(), imu::NodePacketType::heartbeat), 0U);
}

TEST_F(MienNodeTest, HeartbeatsSayWhatItsOwnClockShows) {
  imu::NodeProtocol live = host();
  Conversation talk(*node_, &live);
  talk.run_until(at(0.5));
  node_->begin(at(1));
  talk.run_until(at(6));
  std::size_t heartbeats = 0;
  for (const Conversation::Sent& sent : talk.sent()) {
    const auto message = imu::parse_node_message(sent.bytes);
    const auto* heartbeat = message ? std::get_if<imu::NodeHeartbeat>(&*message) : nullptr;
    if (heartbeat == nullptr) continue;
    ++heartbeats;
    EXPECT_NEAR(to_seconds(heartbeat->time.time_since_epoch()),
                to_seconds(clock_.device(to_seconds(sent.time - at(1))).time_since_epoch()), 2e-6);
    EXPECT_GT(heartbeat->battery_percent, 95);
    EXPECT_LE(heartbeat->battery_percent, 100);
  }
  EXPECT_GE(heartbeats, 9U);
  EXPECT_LE(heartbeats, 12U);
}

TEST_F(MienNodeTest, LooksForAHostThatFellSilent) {
  imu::NodeProtocol live = host();
  Conversation talk(*node_, &live);
  node_->begin(at(0));
  talk.run_until(at(2));
  EXPECT_TRUE(node_->answered());
  talk.connect(nullptr);
  talk.run_until(at(6));
  EXPECT_FALSE(node_->answered());
  const std::size_t hellos = count(talk.sent(), imu::NodePacketType::hello);
  EXPECT_GE(hellos, 2U);
  imu::NodeProtocol again = host(8);
  talk.connect(&again);
  talk.run_until(at(8));
  EXPECT_TRUE(node_->answered());
}

TEST_F(MienNodeTest, SaysHelloToASessionThatDoesNotKnowIt) {
  imu::NodeProtocol first = host(7);
  Conversation talk(*node_, &first);
  node_->begin(at(0));
  talk.run_until(at(2));
  imu::NodeProtocol second = host(8);  // Restarted between two heartbeats.
  talk.connect(&second);
  talk.run_until(at(4));
  EXPECT_EQ(talk.inbox().announcements.size(), 2U);
  EXPECT_EQ(count(talk.sent(), imu::NodePacketType::hello), 2U);
}

TEST_F(MienNodeTest, IgnoresWhatIsNotMeantForIt) {
  ByteWriter other;
  ASSERT_TRUE(imu::encode_node_message(imu::Welcome{.device = 0x024D'4945'4E02, .session = 7}, other));
  node_->receive(at(0), other.bytes());
  std::vector<std::byte> garbage(40, std::byte{0x5A});
  node_->receive(at(0), garbage);
  node_->receive(at(0), {});
  EXPECT_FALSE(node_->answered());
}

class LossyMienNode : public MienNodeTest {
 protected:
  LossyMienNode() : MienNodeTest(0.3) {}
};

TEST_F(LossyMienNode, WhatIsLostIsNotSent) {
  Conversation alone(*node_, nullptr);
  node_->begin(at(1));
  ASSERT_TRUE(node_->play(packets_));
  alone.run_until(at(4.5));
  const auto lost = static_cast<std::size_t>(std::ranges::count(packets_, true, &VirtualPacket::lost));
  EXPECT_GT(lost, 20U);
  EXPECT_EQ(count(alone.sent(), imu::NodePacketType::samples), packets_.size() - lost);
}

}  // namespace
}  // namespace mien::virt::mien_node_test
