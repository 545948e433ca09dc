#include "mien/virtual/eyewear/worn_eyewear.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "mien/builtin_face/builtin_face.h"
#include "mien/eyewear/packet.h"
#include "mien/virtual/eyewear/eyewear_boards.h"
#include "mien/virtual/node_group.h"
#include "mien/virtual/stage.h"
#include "tests/project_path.h"
#include "tests/virtual/three_sensors.h"

namespace mien::virt::worn_eyewear_test {
namespace {

using ::testing::ElementsAre;

/// The rig's own glasses and faults on the built-in face, and a performer who talks for a second and a half.
const Stage& stage(performer::PrologueKind prologue) {
  const auto make = [](performer::PrologueKind kind) {
    Stage stage;
    stage.rig = sensor::read_rig(project_path("rigs/eyewear.toml")).value();
    const EyewearFaults faults = parse_eyewear_faults(stage.rig.faults_toml, "rig").value();
    stage.worn = std::make_shared<WornEyewear>(
        stage.rig, faults, seat_eyewear(builtin_face::make_builtin(), stage.rig, faults, Random(5)).value());
    stage.motion = performer::with_prologue(test::talking(91), kind, Random(3));
    stage.devices = Random(11);
    return stage;
  };
  static const Stage without = make(performer::PrologueKind::none);
  static const Stage brief = make(performer::PrologueKind::brief);
  return prologue == performer::PrologueKind::none ? without : brief;
}

const VirtualSession& session() {
  static const VirtualSession session = play(stage(performer::PrologueKind::brief)).value();
  return session;
}

TEST(EyewearSession, IsWhatALiveSessionWouldHaveSeen) {
  const double seconds = stage(performer::PrologueKind::brief).motion.motion.duration_s() + 0.25;
  // Two boards, 230 scans a second.
  EXPECT_NEAR(static_cast<double>(session().entries.size()), 2 * 230 * seconds, 10);
  EXPECT_EQ(session().samples.size(), 10 * session().entries.size());
  EXPECT_NEAR(static_cast<double>(session().ticks.size()), 60 * seconds, 5);
  ASSERT_EQ(session().truth.size(), session().ticks.size());
  std::vector<std::string> kinds;
  for (const take::Event& event : session().events) kinds.push_back(event.kind);
  EXPECT_THAT(kinds, ElementsAre("neutral", "nod", "shake", "ease"));
  for (std::size_t i = 1; i < session().entries.size(); ++i)
    ASSERT_GE(session().entries[i].arrival, session().entries[i - 1].arrival);
  std::size_t evaluated = 0;
  for (std::size_t i = 0; i < session().truth.size(); ++i) {
    ASSERT_EQ(session().truth[i].time, session().ticks[i].frame);
    evaluated += session().truth[i].evaluated ? 1 : 0;
  }
  EXPECT_NEAR(static_cast<double>(evaluated), 91, 2);
}

TEST(EyewearSession, TheHooksSeeTheJaw) {
  const std::uint16_t hook = stage(performer::PrologueKind::brief).rig.find("jaw_lower_L").value();
  double shut = 0, open = 0;
  int shut_count = 0, open_count = 0;
  const face::MotionCurve curve(stage(performer::PrologueKind::brief).motion.motion);
  for (const take::StoredSample& s : session().samples) {
    if (s.sample.sensor != hook) continue;
    const double light = static_cast<double>(s.sample.values[0]) - static_cast<double>(s.sample.values[1]);
    const float jaw = curve.at(to_seconds(s.arrival.time_since_epoch())).weights[face::shape("jawOpen")];
    if (jaw < 0.1F) {
      shut += light;
      ++shut_count;
    }
    if (jaw > 0.9F) {
      open += light;
      ++open_count;
    }
  }
  ASSERT_GT(open_count, 20);
  EXPECT_GT(std::abs(open / open_count / (shut / shut_count) - 1), 0.1);
}

TEST(EyewearSession, TheSameStageGivesTheSameBits) {
  const Stage& one = stage(performer::PrologueKind::none);
  const VirtualSession a = play(one).value(), b = play(one).value();
  ASSERT_EQ(a.entries.size(), b.entries.size());
  for (std::size_t i = 0; i < a.entries.size(); ++i) {
    ASSERT_EQ(a.entries[i].bytes, b.entries[i].bytes);
    ASSERT_EQ(a.entries[i].arrival, b.entries[i].arrival);
  }
}

TEST(EyewearNodes, SayWhatATakeOfTheSamePerformanceHolds) {
  const VirtualSession take = play(stage(performer::PrologueKind::none)).value();
  const auto nodes =
      NodeGroup::create(stage(performer::PrologueKind::none), NodeLanguage::mien, false).value();
  ASSERT_EQ(nodes->size(), 2U);
  EXPECT_FALSE((*nodes)[0].listens());
  EXPECT_EQ((*nodes)[0].next_datagram(HostTime()), std::nullopt) << "it has not begun";
  nodes->begin(HostTime());
  std::map<std::vector<std::byte>, HostTime> said;
  for (double t = 0; t < 3 && !nodes->finished(); t += 0.001) {
    while (nodes->simulated_s() < t) ASSERT_TRUE(nodes->simulate());
    for (std::size_t n = 0; n < nodes->size(); ++n)
      while (auto datagram = (*nodes)[n].next_datagram(HostTime(from_seconds(t))))
        said.emplace(*datagram, HostTime(from_seconds(t)));
  }
  EXPECT_TRUE(nodes->finished());
  ASSERT_EQ(said.size(), take.entries.size());
  for (const take::LogEntry& entry : take.entries) {
    const auto found = said.find(entry.bytes);
    ASSERT_NE(found, said.end());
    EXPECT_GE(found->second, entry.arrival);
    EXPECT_LE(found->second, entry.arrival + std::chrono::microseconds(1001));
  }
}

TEST(EyewearNodes, GoOnWhereTheyAreToldToAndSpeakTheirOwnLanguage) {
  const auto nodes =
      NodeGroup::create(stage(performer::PrologueKind::none), NodeLanguage::mien, true).value();
  nodes->begin(HostTime());
  while (nodes->simulated_s() < 4) ASSERT_TRUE(nodes->simulate());
  EXPECT_FALSE(nodes->finished());
  EXPECT_EQ(nodes->round_at(3).number, 2U);
  EXPECT_EQ(
      NodeGroup::create(stage(performer::PrologueKind::none), NodeLanguage::slimevr, false).error().code,
      ErrorCode::bad_usage);
}

TEST(EyewearBoards, NeedChannelsInARow) {
  const Stage& own = stage(performer::PrologueKind::none);
  const auto& worn = dynamic_cast<const WornEyewear&>(*own.worn);
  const auto code = [&](const char* device) {
    sensor::Rig rig = own.rig;
    rig.sensors[3].device = device;
    const auto boards = EyewearBoards::put_on(worn.wearer(), rig, worn.faults(), Random(1));
    return boards ? ErrorCode::internal : boards.error().code;
  };
  EXPECT_EQ(code(""), ErrorCode::bad_usage);
  EXPECT_EQ(code("02:4D:49:45:59:00/40"), ErrorCode::bad_usage);
  EXPECT_EQ(code("nothing"), ErrorCode::malformed);
}

TEST(EyewearStage, IsSetByTheRigsKind) {
  StageRequest request;
  request.rig = project_path("rigs/eyewear.toml");
  request.motion = test::talking(30);
  const auto set = set_stage(request);
  ASSERT_TRUE(set) << set.error().message();
  EXPECT_NE(dynamic_cast<const WornEyewear*>(set->worn.get()), nullptr);
  request.devices = "lab";
  EXPECT_EQ(set_stage(request).error().code, ErrorCode::bad_usage);
}

}  // namespace
}  // namespace mien::virt::worn_eyewear_test
