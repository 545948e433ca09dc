#include "mien/sink/sink_kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "mien/core/files.h"
#include "mien/face/livelink_csv.h"
#include "tests/folder.h"

namespace mien::sink::csv_sink_test {
namespace {

using ::testing::HasSubstr;

Result<std::unique_ptr<Sink>> open(const std::string& text) {
  MIEN_TRY_ASSIGN(const Address address, parse_address(text));
  return open_csv_sink(address, text);
}

face::OutputFrame frame_at(std::int64_t index) {
  face::OutputFrame frame;
  frame.time = DeviceTime(std::chrono::hours(1)) + frame_offset(index);
  frame.weights[face::shape("jawOpen")] = static_cast<float>(index % 60) / 60;
  return frame;
}

face::LiveLinkCsv read(const std::filesystem::path& path) {
  const auto text = read_text(path);
  EXPECT_TRUE(text);
  auto csv = face::parse_livelink_csv(text ? *text : "", "csv");
  EXPECT_TRUE(csv) << csv.error().message();
  return csv ? *std::move(csv) : face::LiveLinkCsv{};
}

TEST(CsvSink, WritesWhatTheReaderReads) {
  const mien::test::Folder folder;
  const auto path = folder / "take.csv";
  {
    auto sink = open("csv:" + path.string());
    ASSERT_TRUE(sink) << sink.error().message();
    for (int i = 0; i < 100; ++i) (*sink)->send(frame_at(i), i);
    const Status status = (*sink)->status();
    EXPECT_EQ(status.sent, 100u);
    EXPECT_EQ(status.failed, 0u);
    EXPECT_EQ(status.receivers, 1u);
    EXPECT_EQ(status.rate_hz, 60);
    EXPECT_EQ(status.note, "");
  }
  const auto csv = read(path);
  EXPECT_TRUE(csv.warnings.empty());
  ASSERT_EQ(csv.rows.size(), 100u);
  EXPECT_EQ(csv.rows[0].timecode_text, "01:00:00:00.000");
  EXPECT_EQ(csv.rows[61].timecode_text, "01:00:01:01.000");
  EXPECT_NEAR(csv.rows[30].values[face::arkit_index("jawOpen")], 0.5, 1e-7);
  // The same text as the recording's own writer makes of it.
  EXPECT_EQ(*read_text(path), face::format_livelink_csv(csv));
  const auto motion = face::motion_from_livelink(csv, "take");
  EXPECT_NEAR(motion.rate_hz, 60, 1e-6);
}

TEST(CsvSink, HasARate) {
  const mien::test::Folder folder;
  {
    auto sink = open("csv:" + (folder / "a.csv").string() + "?rate=30");
    ASSERT_TRUE(sink);
    for (int i = 0; i < 120; ++i) (*sink)->send(frame_at(i), i);
  }
  const auto csv = read(folder / "a.csv");
  EXPECT_EQ(csv.rows.size(), 60u);
  EXPECT_NEAR(face::motion_from_livelink(csv, "").rate_hz, 30, 1e-6);
}

TEST(CsvSink, ReplacesNothingUnasked) {
  const mien::test::Folder folder;
  const auto path = (folder / "a.csv").string();
  ASSERT_TRUE(write_file(path, "mine"));
  const auto refused = open("csv:" + path);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("force=1"));
  EXPECT_EQ(*read_text(path), "mine");
  EXPECT_TRUE(open("csv:" + path + "?force=1"));
  EXPECT_EQ(*read_text(path), "mine") << "a session that never began replaces nothing";
  {
    auto sink = open("csv:" + path + "?force=1");
    ASSERT_TRUE(sink);
    (*sink)->send(frame_at(0), 0);
  }
  EXPECT_THAT(*read_text(path), ::testing::StartsWith("Timecode,BlendShapeCount,EyeBlinkLeft"));
  const auto fresh = (folder / "new.csv").string();
  {
    const auto sink = open("csv:" + fresh);
    ASSERT_TRUE(sink);
    EXPECT_TRUE(std::filesystem::exists(fresh)) << "its name is taken";
  }
  EXPECT_FALSE(std::filesystem::exists(fresh)) << "a session that never began leaves nothing";
  EXPECT_EQ(open("csv:" + (folder / "no/a.csv").string()).error().code, ErrorCode::not_found);
  EXPECT_FALSE(open("csv:" + folder.path().string() + "?force=1"));
  EXPECT_FALSE(open("csv:a.csv?subject=x"));
}

/// A session that is killed keeps all but its last half second, in whole lines.
TEST(CsvSink, KeepsWholeLinesWhenKilled) {
  const mien::test::Folder folder;
  const auto path = folder / "killed.csv";
  int news[2];
  ASSERT_EQ(::pipe(news), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto sink = open("csv:" + path.string());
    for (int i = 0; sink && i < 600; ++i) (*sink)->send(frame_at(i), i);
    (void)!::write(news[1], "x", 1);
    ::pause();
    ::_exit(0);
  }
  char byte = 0;
  ASSERT_EQ(::read(news[0], &byte, 1), 1);
  // The writer's thread has been woken; its rows come.
  std::size_t rows = 0;
  for (int i = 0; i < 2000 && rows < 570; ++i) {
    ::usleep(5000);
    const auto text = read_text(path);
    rows = text ? static_cast<std::size_t>(std::ranges::count(*text, '\n')) : 0;
  }
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  ::close(news[0]);
  ::close(news[1]);
  const auto text = read_text(path);
  ASSERT_TRUE(text);
  EXPECT_EQ(text->back(), '\n');
  EXPECT_GE(read(path).rows.size(), 570u);
}

/// A disk that is full costs the rows that did not fit, and says so.
TEST(CsvSink, SurvivesAFullDisk) {
  const mien::test::Folder folder;
  const auto path = folder / "full.csv";
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{50'000, 50'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto sink = open("csv:" + path.string());
    if (!sink) ::_exit(2);
    // A piece that is too long is told until a shorter one fits; once the file is full none does.
    Status status;
    for (int i = 0; i < 60'000 && (i < 600 || status.note.empty()); ++i) {
      (*sink)->send(frame_at(i), i);
      if (i % 30 == 0) {
        ::usleep(2000);
        status = (*sink)->status();
      }
    }
    const bool good = status.failed > 0 && status.receivers == 0 && status.note.starts_with("rows are lost");
    sink->reset();
    ::_exit(good ? 0 : 3);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const auto text = read_text(path);
  ASSERT_TRUE(text);
  EXPECT_LE(text->size(), 50'000u);
  EXPECT_EQ(text->back(), '\n');
  EXPECT_GT(read(path).rows.size(), 20u);
}

}  // namespace
}  // namespace mien::sink::csv_sink_test
