// All nodes of a performer, simulated as they go.
#include "mien/virtual/node_group.h"

#include <gmock/gmock.h>

#include <cmath>
#include <map>

#include "mien/core/files.h"
#include "mien/imu/packet.h"
#include "mien/virtual/session.h"
#include "tests/folder.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt {
namespace {

Stage stage(int frames = 91) {
  Stage stage;
  stage.rig = test::three_sensors();
  stage.faults = test::mild_faults();
  stage.faults.packet_loss = 0.05;
  stage.sites = test::three_sites();
  stage.motion = with_prologue(test::talking(frames), PrologueKind::none, Random(3));
  stage.devices = Random(11);
  return stage;
}

/// What all nodes say, with when, until the performance's time `until_s`.
std::vector<std::pair<HostTime, std::vector<std::byte>>> perform(NodeGroup& nodes, double until_s) {
  std::vector<std::pair<HostTime, std::vector<std::byte>>> all;
  nodes.begin(HostTime());
  for (double t = -0.3; t < until_s && !nodes.finished(); t += 0.001) {
    while (nodes.simulated_s() < t) EXPECT_TRUE(nodes.simulate());
    const HostTime now(from_seconds(t));
    for (std::size_t n = 0; n < nodes.size(); ++n)
      for (auto datagram = nodes[n].say(now); datagram; datagram = nodes[n].say(now))
        all.emplace_back(now, *datagram);
  }
  return all;
}

TEST(NodeGroup, SaysWhatATakeOfTheSamePerformanceHolds) {
  const Stage same = stage();
  const VirtualSession session =
      play_devices(same.motion, same.sites, same.rig, same.faults, same.devices).value();
  NodeGroup nodes(stage(), NodeLanguage::mien, false);
  ASSERT_EQ(nodes.size(), 3U);
  std::multimap<std::vector<std::byte>, HostTime> said;
  for (const auto& [time, bytes] : perform(nodes, 10))
    if (bytes[5] == std::byte{1}) said.emplace(bytes, time);
  EXPECT_TRUE(nodes.finished());
  ASSERT_EQ(said.size(), session.entries.size());
  for (const take::LogEntry& entry : session.entries) {
    const auto found = said.find(entry.bytes);
    ASSERT_NE(found, said.end());
    EXPECT_GE(found->second, entry.arrival);
    EXPECT_LE(found->second,
              std::max(entry.arrival, HostTime(from_seconds(-0.3))) + std::chrono::microseconds(1001));
  }
}

TEST(NodeGroup, GoesOnWhereItIsToldTo) {
  NodeGroup nodes(stage(), NodeLanguage::mien, true);  // A second and a half, and one to come back.
  std::map<std::uint64_t, imu::Packet> last;
  std::size_t packets = 0;
  for (const auto& [time, bytes] : perform(nodes, 20)) {
    const auto packet = imu::parse_packet(bytes);
    if (!packet) continue;
    ++packets;
    const auto before = last.find(packet->device);
    const bool in_order = before == last.end() || packet->sequence > before->second.sequence;
    if (before != last.end() && in_order) {
      EXPECT_GT(packet->time, before->second.time);
    }
    last[packet->device] = *packet;
  }
  EXPECT_FALSE(nodes.finished());
  EXPECT_NEAR(static_cast<double>(packets), 3 * 60 * 20 * 0.95, 100);
  EXPECT_EQ(nodes.round_at(1).number, 1U);
  EXPECT_NEAR(nodes.round_at(1).share, 0.4, 1e-6);
  EXPECT_EQ(nodes.round_at(3).number, 2U);
  EXPECT_NEAR(nodes.round_at(3).share, 0.2, 1e-6);
  EXPECT_EQ(nodes.round_at(10.1).number, 5U);
}

TEST(NodeGroup, SpeaksSlimeVrWhereItIsToldTo) {
  NodeGroup nodes(stage(), NodeLanguage::slimevr, false);
  const auto said = perform(nodes, 5);
  ASSERT_FALSE(said.empty());
  for (const auto& [time, bytes] : said) EXPECT_EQ(bytes[3], std::byte{3});  // Handshakes: nobody greets.
  EXPECT_TRUE(nodes.finished());
}

/// The stage that a request sets.
class SetStage : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_file(folder_ / "rig.toml", test::kRig));
    request_.rig = folder_ / "rig.toml";
    request_.motion = test::talking(45);
    request_.script_name = "talking";
  }
  mien::test::Folder folder_;
  StageRequest request_;
};

TEST_F(SetStage, IsTheSameForTheSameSeed) {
  const Stage one = set_stage(request_).value();
  const Stage same = set_stage(request_).value();
  request_.seed = 2;
  const Stage other = set_stage(request_).value();
  EXPECT_EQ(one.rig_toml, test::kRig);
  EXPECT_FALSE(one.lab);
  EXPECT_EQ(one.sites.size(), 3U);
  EXPECT_EQ(one.motion.motion.frames.size(), same.motion.motion.frames.size());
  Random a = one.devices;
  Random b = same.devices;
  Random c = other.devices;
  const std::uint64_t drawn = a.bits();
  EXPECT_EQ(drawn, b.bits());
  EXPECT_NE(drawn, c.bits());
}

TEST_F(SetStage, NodsInItsPrologueButInLab) {
  EXPECT_GT(set_stage(request_)->motion.times.nod.end_s, set_stage(request_)->motion.times.nod.begin_s);
  request_.devices = "lab";
  const Stage lab = set_stage(request_).value();
  EXPECT_TRUE(lab.lab);
  EXPECT_EQ(lab.motion.times.nod.end_s, lab.motion.times.nod.begin_s);
}

TEST_F(SetStage, RefusesAMotionWithoutFrames) {
  request_.motion = face::Motion{};
  const auto refused = set_stage(request_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  EXPECT_THAT(refused.error().message(), ::testing::HasSubstr("talking"));
}

}  // namespace
}  // namespace mien::virt
