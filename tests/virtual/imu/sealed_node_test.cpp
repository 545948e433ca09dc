// A virtual node that was paired: what it says to a host with its key, and what it hears of others.
#include "mien/virtual/imu/sealed_node.h"

#include <gmock/gmock.h>

#include "mien/imu/packets/node_protocol.h"
#include "mien/virtual/imu/mien_node.h"
#include "tests/virtual/conversation.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::sealed_node_test {
namespace {

using test::at;
using test::Conversation;
using ::testing::Contains;
using ::testing::Each;

imu::SealKey key(std::uint8_t first) {
  imu::SealKey key{.id = 1, .secret = {}};
  key.secret[0] = std::byte{first};
  return key;
}

imu::NodeProtocol host(std::vector<imu::SealKey> keys, std::uint64_t session = 7) {
  return imu::NodeProtocol::create({.session = session, .keys = std::move(keys)}).value();
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
  imu::NodeProtocol live = host({key(5)});
  Conversation talk(*node_, &live);
  talk.run_until(at(0.5));
  EXPECT_TRUE(node_->answered());
  node_->begin(at(1));
  ASSERT_TRUE(inside_->play(packets_));
  talk.run_until(at(4.5));
  EXPECT_TRUE(node_->idle());
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::taken));
  EXPECT_EQ(talk.inbox().readings.size(), 4 * packets_.size());
  for (const Conversation::Sent& sent : talk.sent()) EXPECT_TRUE(imu::is_sealed(sent.bytes));
  // What was taken is not taken again.
  const auto& again = talk.sent().back().bytes;
  EXPECT_EQ(live.receive(at(5), 1, again, talk.inbox()), sensor::Verdict::refused);
}

TEST_F(SealedNodeTest, HearsNoHostWithAnotherKeyOrNone) {
  imu::NodeProtocol other = host({key(6)}), open = host({});
  Conversation talk(*node_, &other);
  talk.run_until(at(2.5));
  EXPECT_THAT(talk.verdicts(), Each(sensor::Verdict::refused));
  EXPECT_FALSE(node_->answered());
  // A welcome that anybody could have written.
  imu::NodeProtocol stranger = host({});
  sensor::Inbox inbox;
  const auto hello = MienNode(1, "", VirtualClock(), faults_).next_datagram(at(0)).value();
  ASSERT_EQ(stranger.receive(at(0), 1, hello, inbox), sensor::Verdict::taken);
  node_->receive(at(3), inbox.reply);
  EXPECT_FALSE(node_->answered());
}

TEST_F(SealedNodeTest, FollowsItsHostIntoAnotherSession) {
  imu::NodeProtocol first = host({key(5)}), second = host({key(5)}, 8);
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

}  // namespace
}  // namespace mien::virt::sealed_node_test
