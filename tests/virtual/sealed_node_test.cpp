// A virtual node that was paired: what it says to a host with its key, and what it hears of others.
#include "mien/virtual/sealed_node.h"

#include <gmock/gmock.h>

#include <memory>
#include <utility>
#include <vector>

#include "mien/eyewear/eyewear_protocol.h"
#include "mien/imu/packets/node_protocol.h"
#include "mien/sensor/sealed_protocol.h"
#include "mien/virtual/imu/mien_node.h"
#include "mien/virtual/speaking_node.h"
#include "tests/virtual/conversation.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::sealed_node_test {
namespace {

using test::at;
using test::Conversation;
using ::testing::Contains;
using ::testing::Each;

sensor::SealKey key(std::uint8_t first) {
  sensor::SealKey key{.id = 1, .secret = {}};
  key.secret[0] = std::byte{first};
  return key;
}

imu::NodeProtocol open_host(std::uint64_t session = 7) {
  return imu::NodeProtocol::create({.session = session}).value();
}

/// A host of nodes and glasses.
sensor::SealedProtocol host(const sensor::SealKey& key, std::uint64_t session = 7) {
  std::vector<std::unique_ptr<sensor::Protocol>> languages;
  languages.push_back(std::make_unique<eyewear::EyewearProtocol>(eyewear::EyewearProtocol::create().value()));
  languages.push_back(std::make_unique<imu::NodeProtocol>(open_host(session)));
  return sensor::SealedProtocol::create(session, {key}, std::move(languages)).value();
}

class SealedNodeTest : public ::testing::Test {
 protected:
  SealedNodeTest() {
    ImuSimulator simulator(faults_, 1, Random(4));
    const face::Motion motion = test::talking(181);
    const auto sites = test::three_sites();
    packets_ = simulator.play(trace_skin(face::MotionCurve(motion), sites, -0.25, 3));
    inside_.emplace(1, "buccinator_L", simulator.clock(), faults_);
    node_.emplace(*inside_, key(5));
  }
  DeviceFaults faults_ = test::mild_faults();
  std::vector<VirtualPacket> packets_;
  std::optional<MienNode> inside_;
  std::optional<SealedNode> node_;
};

TEST_F(SealedNodeTest, IsUnderstoodByAHostWithItsKey) {
  sensor::SealedProtocol live = host(key(5));
  Conversation talk(*node_, &live);
  talk.run_until(at(0.5));
  EXPECT_TRUE(node_->answered());
  node_->begin(at(1));
  ASSERT_TRUE(inside_->play(packets_));
  talk.run_until(at(4.5));
  EXPECT_TRUE(node_->idle());
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::taken));
  EXPECT_EQ(talk.inbox().readings.size(), 4 * packets_.size());
  for (const Conversation::Sent& sent : talk.sent()) EXPECT_TRUE(sensor::is_sealed(sent.bytes));
  // What was taken is not taken again.
  const auto& again = talk.sent().back().bytes;
  EXPECT_EQ(live.receive(at(5), 1, again, talk.inbox()), sensor::Verdict::refused);
}

TEST_F(SealedNodeTest, HearsNoHostWithAnotherKeyOrNone) {
  sensor::SealedProtocol other = host(key(6));
  Conversation talk(*node_, &other);
  talk.run_until(at(2.5));
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::refused));
  EXPECT_FALSE(node_->answered());
  // A welcome that anybody could have written.
  imu::NodeProtocol stranger = open_host();
  sensor::Inbox inbox;
  const auto hello = MienNode(1, "", VirtualClock(), faults_).next_datagram(at(0)).value();
  ASSERT_EQ(stranger.receive(at(0), 1, hello, inbox), sensor::Verdict::taken);
  node_->receive(at(3), inbox.reply);
  EXPECT_FALSE(node_->answered());
}

TEST_F(SealedNodeTest, FollowsItsHostIntoAnotherSession) {
  sensor::SealedProtocol first = host(key(5)), second = host(key(5), 8);
  Conversation talk(*node_, &first);
  node_->begin(at(0));
  talk.run_until(at(1));
  talk.connect(&second);
  talk.run_until(at(6));
  talk.verdicts().clear();
  talk.run_until(at(8));
  EXPECT_TRUE(node_->answered());
  EXPECT_THAT(talk.verdicts(), Contains(sensor::Verdict::taken));
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::taken));
}

std::vector<std::byte> scan(std::uint64_t device, std::uint32_t sequence) {
  eyewear::Packet packet;
  packet.device = device;
  packet.channels = 2;
  packet.sequence = sequence;
  packet.time = DeviceTime(std::chrono::milliseconds(4 * sequence));
  packet.light[0] = {.on = 600, .off = 40};
  return eyewear::encode_packet(packet).value();
}

TEST(SealedGlasses, AskForTheSessionAndAreHeardInIt) {
  constexpr std::uint64_t kGlasses = 0x024D'4945'4E40;
  SpeakingNode glasses(kGlasses);
  SealedNode node(glasses, key(5));
  for (std::uint32_t i = 0; i < 2000; ++i)
    glasses.hand_over({.time = at(0.004 * i), .bytes = scan(kGlasses, i)});
  sensor::SealedProtocol first = host(key(5)), second = host(key(5), 8);
  Conversation talk(node, &first);
  EXPECT_TRUE(node.listens());
  talk.run_until(at(0.5));
  EXPECT_TRUE(node.answered());
  node.begin(at(1));
  talk.run_until(at(3));
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::taken));
  EXPECT_GT(talk.inbox().readings.size(), 900U);
  for (const auto& reading : talk.inbox().readings) EXPECT_EQ(reading.from.device, kGlasses);
  for (const Conversation::Sent& sent : talk.sent()) EXPECT_TRUE(sensor::is_sealed(sent.bytes));

  // Another session begins: what it hears of the old one is refused until it is greeted again.
  talk.connect(&second);
  talk.run_until(at(7.5));
  talk.verdicts().clear();
  talk.run_until(at(8.5));
  EXPECT_THAT(talk.verdicts(), Contains(sensor::Verdict::taken));
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::taken));
}

}  // namespace
}  // namespace mien::virt::sealed_node_test
