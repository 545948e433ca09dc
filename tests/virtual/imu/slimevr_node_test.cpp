// A virtual SlimeVR tracker: what it says when, and that its rotations are the sensor's.
#include "mien/virtual/imu/slimevr_node.h"
#include "mien/core/units.h"

#include <gmock/gmock.h>

#include <cmath>

#include "mien/imu/packets/slimevr_protocol.h"
#include "tests/virtual/conversation.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::slimevr_node_test {
namespace {

namespace slimevr = imu::slimevr;
using test::at;
using test::Conversation;
using ::testing::Each;

/// The ear's sensor of three: the head alone moves it.
class SlimeVrNodeTest : public ::testing::Test {
 protected:
  explicit SlimeVrNodeTest(DeviceFaults faults = test::mild_faults(), bool moves = true) {
    ImuSimulator simulator(faults, 2, Random(4));
    motion_ = test::talking(601);
    if (!moves)
      for (face::MotionFrame& frame : motion_.frames) frame.head = Quat::Identity();
    const auto sites = test::three_sites();
    trajectory_ = trace_skin(face::MotionCurve(motion_), sites, -0.25, 10);
    packets_ = simulator.play(trajectory_);
    clock_ = simulator.clock();
    node_.emplace(2, clock_);
  }

  /// Messages of one kind in all that was sent, with when.
  template <class Message>
  std::vector<std::pair<HostTime, Message>> said(const std::vector<Conversation::Sent>& sent) {
    std::vector<std::pair<HostTime, Message>> out;
    for (const Conversation::Sent& s : sent) {
      std::vector<slimevr::TrackerMessage> messages;
      EXPECT_TRUE(slimevr::parse_tracker_datagram(s.bytes, messages));
      for (const slimevr::TrackerMessage& message : messages)
        if (const auto* found = std::get_if<Message>(&message)) out.emplace_back(s.time, *found);
    }
    return out;
  }

  face::Motion motion_;
  SkinTrajectory trajectory_;
  std::vector<VirtualPacket> packets_;
  VirtualClock clock_;
  std::optional<SlimeVrNode> node_;
};

TEST_F(SlimeVrNodeTest, ShakesHandsEverySecondUntilItIsGreeted) {
  Conversation alone(*node_, nullptr);
  node_->begin(at(0));
  ASSERT_TRUE(node_->play(packets_));
  alone.run_until(at(3.5));
  const auto handshakes = said<slimevr::Handshake>(alone.sent());
  ASSERT_EQ(handshakes.size(), 4U);
  EXPECT_EQ(alone.sent().size(), 4U);  // Nothing else before it is greeted.
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(handshakes[i].first, at(static_cast<double>(i)));
    EXPECT_EQ(handshakes[i].second.mac, 0x024D'4945'4E02U);
    EXPECT_EQ(handshakes[i].second.protocol, slimevr::kProtocolVersion);
  }
  imu::SlimeVrProtocol live;
  alone.connect(&live);
  alone.run_until(at(5));
  EXPECT_TRUE(node_->answered());
  EXPECT_GT(alone.inbox().readings.size(), 50U);
}

TEST_F(SlimeVrNodeTest, TheServerTakesAllThatItSays) {
  imu::SlimeVrProtocol live;
  Conversation talk(*node_, &live);
  talk.run_until(at(0.5));
  node_->begin(at(1));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(12));
  EXPECT_TRUE(node_->idle());
  for (const sensor::Verdict verdict : talk.verdicts())
    EXPECT_TRUE(verdict == sensor::Verdict::taken || verdict == sensor::Verdict::ignored);
  // A hundred a second, as the head never rests.
  EXPECT_NEAR(static_cast<double>(talk.inbox().readings.size()), 1000, 60);
  EXPECT_EQ(said<slimevr::SensorInfo>(talk.sent()).size(), 1U);    // Acknowledged.
  EXPECT_EQ(said<slimevr::FeatureFlags>(talk.sent()).size(), 1U);  // Answered.
  EXPECT_GE(said<slimevr::Heartbeat>(talk.sent()).size(), 20U);
  EXPECT_GE(said<slimevr::Pong>(talk.sent()).size(), 20U);
  EXPECT_GE(said<slimevr::Battery>(talk.sent()).size(), 1U);
  EXPECT_GE(talk.inbox().batteries.size(), 1U);
  EXPECT_EQ(talk.inbox().readings.front().from.device, 0x024D'4945'4E02U);
  EXPECT_EQ(talk.inbox().readings.front().sample.kind, sensor::SampleKind::imu_fused);
}

TEST_F(SlimeVrNodeTest, TheirUpIsUpAndAccelerationHasNoGravity) {
  imu::SlimeVrProtocol live;
  Conversation talk(*node_, &live);
  node_->begin(at(0.5));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(11));
  const auto rotations = said<slimevr::Rotation>(talk.sent());
  const auto accelerations = said<slimevr::Acceleration>(talk.sent());
  ASSERT_EQ(rotations.size(), accelerations.size());
  double largest = 0;
  for (std::size_t i = 300; i < rotations.size(); ++i) {
    Vec3 a(accelerations[i].second.m_s2[0], accelerations[i].second.m_s2[1], accelerations[i].second.m_s2[2]);
    largest = std::max(largest, a.norm());
    // With gravity on again it points up by their world, whatever way the head is turned.
    const auto& q = rotations[i].second.xyzw;
    const Vec3 up = Quat(q[3], q[0], q[1], q[2]).conjugate() * Vec3(0, 0, 9.80665);
    const auto& v = talk.inbox().readings[i].sample.values;
    EXPECT_NEAR((Vec3(v[4], v[5], v[6]) - up - a).norm(), 0, 0.3) << i;
  }
  EXPECT_LT(largest, 3);  // A nod of 17 degrees at half a hertz, 12 cm from the neck.
}

TEST_F(SlimeVrNodeTest, NumbersRiseAndBundlesComeOnceTheyAreUnderstood) {
  imu::SlimeVrProtocol live;
  Conversation talk(*node_, &live);
  node_->begin(at(0.5));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(3));
  std::uint64_t last = 0;
  std::size_t bundled = 0;
  for (const Conversation::Sent& sent : talk.sent()) {
    std::vector<slimevr::TrackerMessage> messages;
    const auto header = slimevr::parse_tracker_datagram(sent.bytes, messages).value();
    if (header.number != 0) {
      EXPECT_GT(header.number, last);
      last = header.number;
    }
    bundled += messages.size() == 2 ? 1 : 0;
  }
  EXPECT_GT(bundled, 200U);
}

TEST_F(SlimeVrNodeTest, WithoutBundlesEachIsADatagramOfItsOwn) {
  ByteWriter greeting;
  slimevr::encode_server_message(slimevr::Greeting{}, greeting);
  Conversation alone(*node_, nullptr);
  node_->receive(at(0), greeting.bytes());
  node_->begin(at(0));
  ASSERT_TRUE(node_->play(packets_));
  alone.run_until(at(2.9));
  const auto rotations = said<slimevr::Rotation>(alone.sent());
  EXPECT_GT(rotations.size(), 250U);
  EXPECT_EQ(said<slimevr::Acceleration>(alone.sent()).size(), rotations.size());
  EXPECT_EQ(said<slimevr::SensorInfo>(alone.sent()).size(), 3U);    // Never acknowledged.
  EXPECT_EQ(said<slimevr::FeatureFlags>(alone.sent()).size(), 6U);  // Never answered.
  for (const Conversation::Sent& sent : alone.sent()) {
    std::vector<slimevr::TrackerMessage> messages;
    ASSERT_TRUE(slimevr::parse_tracker_datagram(sent.bytes, messages));
    EXPECT_EQ(messages.size(), 1U);
  }
}

TEST_F(SlimeVrNodeTest, LooksForAServerThatFellSilent) {
  imu::SlimeVrProtocol live;
  Conversation talk(*node_, &live);
  node_->begin(at(0));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(2));
  ASSERT_TRUE(node_->answered());
  talk.connect(nullptr);
  talk.run_until(at(4.4));
  EXPECT_TRUE(node_->answered());
  talk.run_until(at(5.2));
  EXPECT_FALSE(node_->answered());
  const std::size_t rotations = said<slimevr::Rotation>(talk.sent()).size();
  imu::SlimeVrProtocol again;
  talk.connect(&again);
  talk.run_until(at(8));
  EXPECT_TRUE(node_->answered());
  EXPECT_GT(said<slimevr::Rotation>(talk.sent()).size(), rotations + 100);
}

class PerfectSlimeVrNode : public SlimeVrNodeTest {
 protected:
  PerfectSlimeVrNode() : SlimeVrNodeTest(DeviceFaults{}) {}
};

TEST_F(PerfectSlimeVrNode, RotationsAreTheSensorsBetweenAnyTwoMoments) {
  imu::SlimeVrProtocol live;
  Conversation talk(*node_, &live);
  node_->begin(at(0.5));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(11));
  // The heading of a fusion is free, and the mounting unknown: the turn since another moment is neither,
  // about the sensor's own axes and in length.
  const auto& readings = talk.inbox().readings;
  const face::MotionCurve curve(motion_);
  const auto turn = [&](std::size_t i) {
    const auto& v = readings[i].sample.values;
    return Quat(v[0], v[1], v[2], v[3]);
  };
  std::size_t checked = 0;
  for (std::size_t i = 300; i + 120 < readings.size(); i += 37) {
    const double a = to_seconds(readings[i].sample.time.time_since_epoch()) - 0.5;
    const double b = to_seconds(readings[i + 120].sample.time.time_since_epoch()) - 0.5;
    const double expected = angle_between(curve.at(a).head, curve.at(b).head);
    EXPECT_NEAR(angle_between(turn(i), turn(i + 120)), expected, 0.7 * kRadPerDeg) << i;
    ++checked;
  }
  EXPECT_GT(checked, 10U);
}

class StillSlimeVrNode : public SlimeVrNodeTest {
 protected:
  StillSlimeVrNode() : SlimeVrNodeTest(DeviceFaults{}, false) {}
};

TEST_F(StillSlimeVrNode, SaysNothingOfARotationThatDoesNotChange) {
  imu::SlimeVrProtocol live;
  Conversation talk(*node_, &live);
  node_->begin(at(0.5));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(11));
  EXPECT_LE(said<slimevr::Rotation>(talk.sent()).size(), 20U);
  EXPECT_GE(said<slimevr::Heartbeat>(talk.sent()).size(), 20U);  // The board still answers.
}

class LossySlimeVrNode : public SlimeVrNodeTest {
 protected:
  static DeviceFaults lossy() {
    DeviceFaults faults = test::mild_faults();
    faults.packet_loss = 0.2;
    faults.radio_delay_ms = 20;
    return faults;
  }
  LossySlimeVrNode() : SlimeVrNodeTest(lossy()) {}
};

TEST_F(LossySlimeVrNode, LostDatagramsLeaveAGapInTheNumbers) {
  imu::SlimeVrProtocol live;
  Conversation talk(*node_, &live);
  node_->begin(at(0.5));
  ASSERT_TRUE(node_->play(packets_));
  talk.run_until(at(11));
  const auto rotations = static_cast<double>(said<slimevr::Rotation>(talk.sent()).size());
  EXPECT_NEAR(rotations, 800, 80);
  std::vector<slimevr::TrackerMessage> messages;
  const auto last = slimevr::parse_tracker_datagram(talk.sent().back().bytes, messages).value();
  EXPECT_GT(static_cast<double>(last.number), static_cast<double>(talk.sent().size()) + 120);
}

TEST_F(SlimeVrNodeTest, IgnoresGarbage) {
  std::vector<std::byte> garbage(64, std::byte{0x5A});
  node_->receive(at(0), garbage);
  node_->receive(at(0), {});
  EXPECT_FALSE(node_->answered());
}

}  // namespace
}  // namespace mien::virt::slimevr_node_test
