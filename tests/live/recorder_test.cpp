#include "mien/live/recorder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <future>
#include <memory>
#include <thread>

#include "tests/folder.h"

namespace mien::live::recorder_test {
namespace {

constexpr const char* kRig =
    "name = \"one\"\nreference = \"ear\"\n[[sensor]]\nname = \"ear\"\nkind = \"imu\"\nsite = \"mastoid\"\n"
    "side = \"L\"\nrole = \"head\"\n";

take::Header header() {
  take::Header header;
  header.software = "test";
  header.rig_toml = kRig;
  return header;
}

void record_seconds(Recorder& recorder, int from, int to) {
  const std::array<std::byte, 40> bytes{};
  for (int i = 60 * from; i < 60 * to; ++i) {
    const HostTime arrival(frame_offset(i));
    sensor::Sample sample;
    sample.time = DeviceTime(frame_offset(i));
    sample.sequence = static_cast<std::uint32_t>(i);
    sample.count = 6;
    recorder.entry(arrival, "udp://127.0.0.1:1", bytes, {&sample, 1});
    recorder.tick({i, DeviceTime(frame_offset(i)), arrival, true});
    if (i % 600 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST(Recorder, ATakeThatIsAskedForLateBeginsWithTheSession) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  record_seconds(recorder, 0, 20);
  ASSERT_TRUE(recorder.start(folder / "late.mien", header(), false));
  EXPECT_FALSE(recorder.start(folder / "other.mien", header(), false));
  record_seconds(recorder, 20, 25);
  recorder.command(HostTime(std::chrono::seconds(26)), R"({"command": "recentre"})");
  recorder.end({{"live.hash", "abc"}});
  ASSERT_TRUE(recorder.wait());
  EXPECT_FALSE(recorder.state().on);

  const auto take = take::Take::open(folder / "late.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_TRUE(take->finished());
  EXPECT_EQ(take->ticks().value().size(), 25u * 60);
  const auto entries = take->entries().value();
  ASSERT_EQ(entries.size(), 25u * 60 + 1);
  EXPECT_EQ(entries.back().source, "page");
  EXPECT_EQ(take->samples().value().size(), 25u * 60);
  EXPECT_EQ(take->note("live.hash").value(), "abc");

  // And once more, from the beginning again.
  ASSERT_TRUE(recorder.start(folder / "again.mien", header(), false));
  recorder.end({});
  ASSERT_TRUE(recorder.wait());
  EXPECT_EQ(take::Take::open(folder / "again.mien").value().ticks().value().size(), 25u * 60);
}

TEST(Recorder, NotesEventsOfOtherThreadsBehindWhatWasHandedOver) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  record_seconds(recorder, 0, 1);
  const DeviceTime early(std::chrono::milliseconds(500)), late(std::chrono::milliseconds(1500));
  recorder.note({"video", early, early, R"({"file":"a.webm"})"});
  ASSERT_TRUE(recorder.start(folder / "a.mien", header(), false));
  record_seconds(recorder, 1, 2);
  recorder.note({"video_over", late, late, "{}"});
  recorder.end({});
  ASSERT_TRUE(recorder.wait());
  const auto take = take::Take::open(folder / "a.mien");
  ASSERT_TRUE(take) << take.error().message();
  const auto events = take->events().value();
  ASSERT_EQ(events.size(), 2u) << "also what was noted just before its end";
  EXPECT_EQ(events[0].kind, "video");
  EXPECT_EQ(events[0].begin, early);
  EXPECT_EQ(events[0].json, R"({"file":"a.webm"})");
  EXPECT_EQ(events[1].kind, "video_over");
}

TEST(Recorder, CountsTheSecondsSinceItWasAskedFor) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  record_seconds(recorder, 0, 20);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // What was handed over is taken by then.
  ASSERT_TRUE(recorder.start(folder / "late.mien", header(), false));
  const auto reached = [&](double seconds) {
    for (int i = 0; i < 1000 && recorder.state().seconds < seconds; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return recorder.state().seconds;
  };
  record_seconds(recorder, 20, 25);
  EXPECT_NEAR(reached(4.9), 5, 0.1) << "not of the session";
  recorder.end({});
  ASSERT_TRUE(recorder.wait());
  EXPECT_EQ(take::Take::open(folder / "late.mien").value().ticks().value().size(), 25u * 60);
}

TEST(Recorder, SaysWhyItCannotBegin) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  EXPECT_FALSE(recorder.start(folder / "no" / "such.mien", header(), false));
  ASSERT_TRUE(recorder.start(folder / "a.mien", header(), false));
  recorder.end({});
  ASSERT_TRUE(recorder.wait());
  EXPECT_FALSE(recorder.start(folder / "a.mien", header(), false)) << "it exists";
  EXPECT_TRUE(recorder.start(folder / "a.mien", header(), true));
}

/// Asks for a recording, and tells whether it begins.
std::future<Result<void>> ask_for(Recorder& recorder, const std::filesystem::path& take) {
  // Shared: who sets it may still be at it when the result is there.
  const auto begun = std::make_shared<std::promise<Result<void>>>();
  recorder.start(take, header(), false,
                 [begun](Result<void> result) { begun->set_value(std::move(result)); });
  return begun->get_future();
}

/// Begins a recording, and asks for more before the recorder goes on: what that is comes in one turn.
template <class Asks>
void begin_and_ask(Recorder& recorder, const std::filesystem::path& take, Asks&& asks) {
  const auto begun = std::make_shared<std::promise<std::thread::id>>();
  const auto asked = std::make_shared<std::promise<void>>();
  recorder.start(take, header(), false, [begun, go_on = asked->get_future().share()](Result<void> result) {
    EXPECT_TRUE(result) << result.error().message();
    begun->set_value(std::this_thread::get_id());
    go_on.wait();
  });
  EXPECT_NE(begun->get_future().get(), std::this_thread::get_id());
  asks();
  asked->set_value();
}

TEST(Recorder, RefusesASecondRecordingAndEndsTheFirst) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  record_seconds(recorder, 0, 2);
  std::future<Result<void>> second;
  begin_and_ask(recorder, folder / "first.mien", [&] {
    second = ask_for(recorder, folder / "second.mien");
    recorder.end({{"live.hash", "early"}});
  });
  ASSERT_TRUE(recorder.wait());
  const Result<void> refused = second.get();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::bad_usage);
  EXPECT_FALSE(std::filesystem::exists(folder / "second.mien"));
  EXPECT_EQ(recorder.state().path, folder / "first.mien");
  const auto take = take::Take::open(folder / "first.mien");
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_TRUE(take->finished());
  EXPECT_EQ(take->ticks().value().size(), 2u * 60);
  EXPECT_EQ(take->note("live.hash").value(), "early");
}

TEST(Recorder, AnEndIsOfTheRecordingBeforeItAndOfNoneAfter) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  std::future<Result<void>> second;
  begin_and_ask(recorder, folder / "first.mien", [&] {
    recorder.end({});
    recorder.end({});
    second = ask_for(recorder, folder / "second.mien");
    EXPECT_TRUE(recorder.state().on);
  });
  ASSERT_TRUE(second.get());
  record_seconds(recorder, 0, 2);
  EXPECT_TRUE(recorder.state().on);
  EXPECT_FALSE(recorder.state().beginning);
  EXPECT_EQ(recorder.state().path, folder / "second.mien");
  EXPECT_TRUE(take::Take::open(folder / "first.mien").value().finished());
  recorder.end({});
  ASSERT_TRUE(recorder.wait());
  const std::vector<Recorder::Ended> ended = recorder.take_ended();
  ASSERT_EQ(ended.size(), 2U);
  EXPECT_EQ(ended[0].path, folder / "first.mien");
  EXPECT_EQ(ended[1].path, folder / "second.mien");
  EXPECT_EQ(ended[1].error, "");
  EXPECT_TRUE(recorder.take_ended().empty());
  EXPECT_EQ(take::Take::open(folder / "second.mien").value().ticks().value().size(), 2u * 60);
}

TEST(Recorder, KeepsTheSessionBesideTheTakesInAFileWithoutAName) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  EXPECT_TRUE(folder.files().empty());
  bool found = false;
  for (const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code gone;
    const std::string there = std::filesystem::read_symlink(file.path(), gone).string();
    found = found || there.starts_with(folder.path().string() + "/");
  }
  EXPECT_TRUE(found);
}

TEST(Recorder, WithoutAFolderNothingIsRecordedAndThatIsSaid) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder / "none");
  record_seconds(recorder, 0, 1);
  const auto started = recorder.start(folder / "a.mien", header(), false);
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().message().find("does not take the session"), std::string::npos)
      << started.error().message();
  EXPECT_FALSE(recorder.state().on);
}

TEST(Recorder, NamesTheSenderOfEachEntry) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  Recorder recorder(folder.path());
  const std::array<std::byte, 4> bytes{};
  for (const char* source : {"udp://127.0.0.1:200", "udp://127.0.0.1:3", "udp://127.0.0.1:200"})
    recorder.entry(HostTime(), source, bytes, {});
  ASSERT_TRUE(recorder.start(folder / "a.mien", header(), false));
  recorder.end({});
  ASSERT_TRUE(recorder.wait());
  const auto entries = take::Take::open(folder / "a.mien").value().entries().value();
  ASSERT_EQ(entries.size(), 3u);
  EXPECT_EQ(entries[1].source, "udp://127.0.0.1:3");
  EXPECT_EQ(entries[2].source, "udp://127.0.0.1:200");
}

}  // namespace
}  // namespace mien::live::recorder_test
