#include "mien/session/performed_prologue.h"

#include <gtest/gtest.h>

#include "mien/session/prompt.h"
#include "mien/session/replay.h"
#include "tests/folder.h"
#include "tests/session/session_run.h"

namespace mien::session::performed_prologue_test {
namespace {

using tracker::Step;

take::Event event(const char* kind, int begin, int end, std::string json = {}) {
  return {kind, DeviceTime(frame_offset(begin)), DeviceTime(frame_offset(end)), std::move(json)};
}

const std::vector<take::Event> kPrologue = {event("neutral", 10, 100),
                                            event("nod", 100, 200),
                                            event("prompt", 200, 260, R"({"name": "smile"})"),
                                            event("range", 200, 300),
                                            event("gaze", 320, 400, gaze_event_json(face::gaze_targets()[1])),
                                            event("ease", 400, 430)};

TEST(PerformedPrologue, IsTheStepsOfThePerformancesEvents) {
  const auto command = performed_prologue(kPrologue);
  ASSERT_TRUE(command);
  ASSERT_EQ(command->steps.size(), 4u);
  EXPECT_EQ(command->steps[0].step, Step::neutral);
  EXPECT_EQ(command->steps[1].step, Step::nod);
  EXPECT_EQ(command->steps[1].end, kPrologue[1].end);
  EXPECT_TRUE(command->steps[2].range);
  EXPECT_EQ(command->steps[3].look, &face::gaze_targets()[1]);
}

TEST(PerformedPrologue, AsACommandItIsReadBack) {
  const Calibrate written = *performed_prologue(kPrologue);
  const auto read = parse_command(write_command(written));
  ASSERT_TRUE(read) << read.error().message();
  const auto& steps = std::get<Calibrate>(*read).steps;
  ASSERT_EQ(steps.size(), written.steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].step, written.steps[i].step);
    EXPECT_EQ(steps[i].range, written.steps[i].range);
    EXPECT_EQ(steps[i].look, written.steps[i].look);
    EXPECT_EQ(steps[i].begin, written.steps[i].begin);
    EXPECT_EQ(steps[i].end, written.steps[i].end);
  }
}

TEST(PerformedPrologue, StepsThatAreNoneAreRefused) {
  const char* const kWrong[] = {
      R"({"command": "calibrate"})",
      R"({"command": "calibrate", "steps": []})",
      R"({"command": "calibrate", "steps": 7})",
      R"({"command": "calibrate", "steps": [3]})",
      R"({"command": "calibrate", "steps": [{"step": "jump", "begin_ns": 1, "end_ns": 2}]})",
      R"({"command": "calibrate", "steps": [{"step": "gaze", "begin_ns": 1, "end_ns": 2}]})",
      R"({"command": "calibrate", "steps": [{"step": "nod", "begin_ns": 2, "end_ns": 2}]})",
      R"({"command": "calibrate", "steps": [{"step": "nod", "begin_ns": 0.5, "end_ns": 2}]})",
      R"({"command": "calibrate", "steps": [{"step": "nod", "begin_ns": 5, "end_ns": 9},
                                            {"step": "shake", "begin_ns": 1, "end_ns": 2}]})",
      R"({"command": "calibrate", "kind": "full", "steps": [{"step": "nod", "begin_ns": 1, "end_ns": 2}]})",
      R"({"command": "calibrate", "steps": [{"step": "nod", "begin_ns": 1, "end_ns": 18446744073709551615}]})",
      R"({"command": "calibrate", "steps": [{"step": "nod", "begin_ns": -9223372036854775808, "end_ns": 2}]})"};
  for (const char* const json : kWrong) EXPECT_FALSE(parse_command(json)) << json;
}

TEST(PerformedPrologue, ASessionsOwnCalibrationIsNone) {
  EXPECT_FALSE(performed_prologue({}));
  std::vector<take::Event> events = kPrologue;
  events[0].json = R"({"found": true})";
  EXPECT_FALSE(performed_prologue(events));
  events[0].json = R"({"guided": true})";
  EXPECT_FALSE(performed_prologue(events));
  EXPECT_FALSE(performed_prologue({{kPrologue[4]}})) << "targets alone are of a calibration that failed";
}

TEST(PerformedPrologue, OfVeryManyStepsTheFirstAreACommandThatIsReadBack) {
  std::vector<take::Event> events;
  for (int i = 0; i < 1500; ++i) events.push_back(event("neutral", 10 * i, 10 * i + 5));
  const auto command = performed_prologue(events);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->steps.size(), Calibrate::kMostSteps);
  EXPECT_TRUE(parse_command(write_command(*command)));
  events.assign(1, event("neutral", 5, 5));
  EXPECT_FALSE(performed_prologue(events)) << "it has no length";
}

TEST(PerformedPrologue, CalibratesASessionThatFollowsIt) {
  const virt::VirtualSession performed = test::performance(2);
  const auto with = test::session();
  std::size_t frames = 0;
  ASSERT_TRUE(
      replay(performed.events, performed.entries, performed.ticks, *with, [&](const auto&, const auto&) {
        ++frames;
        return true;
      }));
  EXPECT_EQ(frames, performed.ticks.size());
  ASSERT_FALSE(with->versions().empty());
  EXPECT_EQ(with->versions().front().origin, "guided");
  ASSERT_NE(with->features(), nullptr);
  EXPECT_TRUE(with->features()->sensors.front().has_rotation);

  int seen = 0;
  EXPECT_FALSE(replay(performed.events, performed.entries, performed.ticks, *test::session(),
                      [&](const auto&, const auto&) { return ++seen < 10; }));
  EXPECT_EQ(seen, 10);
}

TEST(PerformedPrologue, TakesWithAndWithoutItInTheirLogAreReplayedAlike) {
  const virt::VirtualSession performed = test::performance(1);
  const mien::test::Folder folder;
  std::vector<std::string> hashes;
  for (const bool in_log : {true, false}) {
    take::Header header{.software = "mien test", .rig_toml = virt::test::kRig};
    const auto path = folder / (in_log ? "new.mien" : "old.mien");
    auto writer = take::TakeWriter::create(path, header, true).value();
    for (const take::Event& one : performed.events) writer.add_event(one);
    const std::int64_t moved =
        in_log ? begin_log(performed.events, performed.entries.front().arrival, writer) : 0;
    EXPECT_EQ(moved, in_log ? 1 : 0);
    for (const take::LogEntry& entry : performed.entries)
      writer.add_entry(entry.arrival, entry.source, entry.bytes);
    for (take::Tick tick : performed.ticks) {
      tick.after_entry += moved;
      writer.add_tick(tick);
    }
    ASSERT_TRUE(writer.finish());
    const auto replayed = test::session();
    ASSERT_TRUE(
        replay(take::Take::open(path).value(), *replayed, [](const auto&, const auto&) { return true; }));
    EXPECT_FALSE(replayed->versions().empty());
    hashes.push_back(replayed->hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(PerformedPrologue, StepsThatHaveBegunAreRefused) {
  const auto session = test::session();
  session->tick(DeviceTime(frame_offset(50)), HostTime(frame_offset(50)));
  const auto late = session->command({}, write_command(*performed_prologue(kPrologue)));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::out_of_range);
}

}  // namespace
}  // namespace mien::session::performed_prologue_test
