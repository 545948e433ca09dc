// All nodes of a performer, simulated as they go.
#include "mien/virtual/node_group.h"

#include <gtest/gtest.h>

#include <map>

#include "mien/imu/packets/packet.h"
#include "mien/virtual/imu/worn_imus.h"
#include "mien/virtual/session.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::node_group_test {
namespace {

Stage stage(int frames = 91) {
  Stage stage;
  stage.rig = test::three_sensors();
  DeviceFaults faults = test::mild_faults();
  faults.packet_loss = 0.05;
  stage.worn = std::make_shared<WornImus>(stage.rig, faults, test::three_sites());
  stage.motion = performer::with_prologue(test::talking(frames), performer::PrologueKind::none, Random(3));
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
      for (auto datagram = nodes[n].next_datagram(now); datagram; datagram = nodes[n].next_datagram(now))
        all.emplace_back(now, *datagram);
  }
  return all;
}

TEST(NodeGroup, SaysWhatATakeOfTheSamePerformanceHolds) {
  const Stage same = stage();
  const VirtualSession session = play(same).value();
  const auto group = NodeGroup::create(stage(), NodeLanguage::mien, false).value();
  NodeGroup& nodes = *group;
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
  const auto group = NodeGroup::create(stage(), NodeLanguage::mien, true).value();
  NodeGroup& nodes = *group;  // A second and a half, and one to come back.
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
  const auto group = NodeGroup::create(stage(), NodeLanguage::slimevr, false).value();
  NodeGroup& nodes = *group;
  const auto said = perform(nodes, 5);
  ASSERT_FALSE(said.empty());
  for (const auto& [time, bytes] : said) EXPECT_EQ(bytes[3], std::byte{3});  // Handshakes: nobody greets.
  EXPECT_TRUE(nodes.finished());
}

}  // namespace
}  // namespace mien::virt::node_group_test
