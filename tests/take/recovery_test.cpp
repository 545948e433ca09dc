// A recording that was cut off: by a kill at any moment, inside a commit, by a full disk.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>

#include "mien/core/random.h"
#include "mien/take/database.h"
#include "mien/take/take.h"
#include "tests/take/example_take.h"

namespace mien::take::recovery_test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Runs `work` in a process of its own.
pid_t start_process(const std::function<int()>& work) {
  const pid_t process = ::fork();
  if (process == 0) ::_exit(work());
  return process;
}
int wait_for(pid_t process) {
  int status = 0;
  EXPECT_EQ(::waitpid(process, &status, 0), process);
  return status;
}
/// The exit status of `work`, run in a process of its own.
int run_process(const std::function<int()>& work) {
  const int status = wait_for(start_process(work));
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// What a recording child tells the test, whatever happens to it.
struct Recorded {
  std::atomic<std::int64_t> arrival_ns = 0;  ///< Of the last packet that the writer took.
  std::atomic<std::int64_t> stall_ns =
      0;  ///< Longest time between two packets, a millisecond if all is well.
};

/// A page that parent and children share.
class SharedPage {
 public:
  SharedPage()
      : page_(::mmap(nullptr, sizeof(Recorded) * kSlots, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS,
                     -1, 0)) {}
  SharedPage(const SharedPage&) = delete;
  SharedPage& operator=(const SharedPage&) = delete;
  ~SharedPage() { ::munmap(page_, sizeof(Recorded) * kSlots); }
  Recorded& operator[](std::size_t slot) { return static_cast<Recorded*>(page_)[slot]; }
  static constexpr std::size_t kSlots = 64;

 private:
  void* page_;
};

/// Records a packet a millisecond until it is killed. Pacing is the point here: it is what a live recording
/// is.
int record_for_ever(const fs::path& path, Recorded& recorded) {
  auto writer = TakeWriter::create(path, test::example_header(), false);
  if (!writer) return 1;
  const auto start = std::chrono::steady_clock::now();
  for (std::int64_t id = 1; writer->status(); ++id) {
    const timespec pause = {0, 1'000'000};
    ::nanosleep(&pause, nullptr);
    const HostTime arrival(std::chrono::steady_clock::now() - start);
    test::add_example(*writer, id, arrival);
    const std::int64_t now_ns = arrival.time_since_epoch().count();
    recorded.stall_ns.store(std::max(recorded.stall_ns.load(), now_ns - recorded.arrival_ns.load()));
    recorded.arrival_ns.store(now_ns);
  }
  return 1;
}

/// The take is a prefix of what record_for_ever() gave; returns the arrival of its last packet.
std::int64_t check_prefix(const Take& take) {
  EXPECT_FALSE(take.finished());
  const auto checked = take.check();
  EXPECT_TRUE(checked) << checked.error().message();
  const auto entries = take.entries().value();
  const auto samples = take.samples().value();
  const auto ticks = take.ticks().value();
  const auto truth = take.truth().value();
  const auto count = static_cast<std::int64_t>(entries.size());
  for (std::int64_t id = 1; id <= count; ++id) {
    const LogEntry& entry = entries[static_cast<std::size_t>(id - 1)];
    EXPECT_EQ(entry.id, id);
    EXPECT_EQ(entry.bytes, test::example_bytes(id));
  }
  // A kill may fall between a packet and its sample, no further apart.
  const auto one_less = [](std::size_t have, std::int64_t whole) {
    return static_cast<std::int64_t>(have) == whole || static_cast<std::int64_t>(have) == whole - 1;
  };
  EXPECT_TRUE(one_less(samples.size(), count)) << samples.size() << " of " << count;
  EXPECT_TRUE(one_less(ticks.size(), count / 16)) << ticks.size() << " of " << count;
  EXPECT_TRUE(one_less(truth.size(), count / 16)) << truth.size() << " of " << count;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto id = static_cast<std::int64_t>(i) + 1;
    EXPECT_EQ(samples[i].entry, id);
    EXPECT_EQ(samples[i].sample.values, test::example_sample(id).values);
  }
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_EQ(truth[i].weights, test::example_truth(static_cast<std::int64_t>(i) + 1).weights);
  return entries.empty() ? 0 : entries.back().arrival.time_since_epoch().count();
}

/// How long the disk itself holds a small write up, seconds: what a loaded machine adds to every commit.
class DiskProbe {
 public:
  explicit DiskProbe(const fs::path& path)
      : file_(::open(path.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600)) {}
  ~DiskProbe() { ::close(file_); }
  DiskProbe(const DiskProbe&) = delete;
  DiskProbe& operator=(const DiskProbe&) = delete;

  void sample() {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(::pwrite(file_, "x", 1, 0), 1);
    EXPECT_EQ(::fsync(file_), 0);
    worst_s_ =
        std::max(worst_s_, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  [[nodiscard]] double worst_s() const { return worst_s_; }

 private:
  int file_;
  double worst_s_ = 0;
};

TEST(Recovery, KilledAtAnyMomentItLosesAtMostASecond) {
  constexpr std::size_t kAtOnce = 10;
  constexpr int kWaves = 5;
  const mien::test::Folder folder;
  SharedPage page;
  Random random(11);
  double worst_s = 0;
  int journals = 0;
  DiskProbe disk(folder.path() / "probe");
  for (int wave = 0; wave < kWaves; ++wave) {
    std::vector<pid_t> recorders;
    std::vector<double> kill_at_s;
    std::vector<fs::path> paths;
    for (std::size_t i = 0; i < kAtOnce; ++i) {
      paths.push_back(folder.path() / (std::to_string(wave) + "_" + std::to_string(i) + ".mien"));
      page[i].arrival_ns.store(0);
      page[i].stall_ns.store(0);
      // Beyond a second, so that losing a second would show.
      kill_at_s.push_back(random.uniform(0.05, 2.6));
      recorders.push_back(start_process([&, i] { return record_for_ever(paths[i], page[i]); }));
    }
    // Each is killed once it has recorded that long by its own clock.
    std::vector<bool> killed(kAtOnce);
    std::uint64_t rounds = 0;
    for (std::size_t left = kAtOnce; left > 0;) {
      const timespec pause = {0, 500'000};
      ::nanosleep(&pause, nullptr);
      if (++rounds % 64 == 0) disk.sample();
      for (std::size_t i = 0; i < kAtOnce; ++i) {
        if (killed[i] || static_cast<double>(page[i].arrival_ns.load()) * 1e-9 < kill_at_s[i]) continue;
        ASSERT_EQ(::kill(recorders[i], SIGKILL), 0);
        const int status = wait_for(recorders[i]);
        ASSERT_TRUE(WIFSIGNALED(status)) << "the recorder ended by itself";
        killed[i] = true;
        --left;
      }
    }
    // A machine that stood still did so for every thread of every recorder.
    double stall_s = 0;
    for (std::size_t i = 0; i < kAtOnce; ++i)
      stall_s = std::max(stall_s, static_cast<double>(page[i].stall_ns.load()) * 1e-9);
    for (std::size_t i = 0; i < kAtOnce; ++i) {
      SCOPED_TRACE(paths[i].filename().string());
      journals += fs::exists(paths[i].string() + "-journal") ? 1 : 0;
      const auto take = Take::open(paths[i]);
      ASSERT_TRUE(take) << take.error().message();
      const double lost_s = static_cast<double>(page[i].arrival_ns.load() - check_prefix(*take)) * 1e-9;
      // A commit waits for the disk several times (journal, file, folder) and for a core; what others keep
      // busy is not ours to answer for.
      EXPECT_LE(lost_s, 1.0 + 6 * disk.worst_s() + 2 * stall_s);
      worst_s = std::max(worst_s, lost_s);
    }
  }
  RecordProperty("worst_loss_ms", static_cast<int>(worst_s * 1e3));
  RecordProperty("killed_inside_a_commit", journals);
  std::printf("worst loss %.0f ms, %d of 50 killed inside a commit\n", worst_s * 1e3, journals);
}

/// Leaves a take as a kill inside a commit does: some of the rows' pages are in the file, the journal beside
/// it has what they were.
void cut_off_inside_a_commit(const fs::path& path) {
  test::write_example(path, 500);
  const std::string before = test::read_raw(path);
  EXPECT_EQ(run_process([&] {
              sqlite3* database = nullptr;
              if (sqlite3_open(path.c_str(), &database) != SQLITE_OK) return 1;
              // So small a cache that pages go to the file long before the commit, which never comes.
              return sqlite3_exec(database,
                                  "PRAGMA cache_size=2; BEGIN IMMEDIATE; UPDATE log SET bytes=zeroblob(200);"
                                  "DELETE FROM sample; UPDATE truth SET weights=x''",
                                  nullptr, nullptr, nullptr);
            }),
            0);
  EXPECT_NE(test::read_raw(path), before) << "nothing of the commit reached the file";
  EXPECT_GT(fs::file_size(path.string() + "-journal"), 0U);
}

TEST(Recovery, RollsBackTheCommitThatWasCutOff) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  cut_off_inside_a_commit(path);
  EXPECT_EQ(test::read_everything(path), "");
  EXPECT_EQ(Take::open(path).value().samples().value().size(), 500U);
  EXPECT_FALSE(fs::exists(folder / "a.mien-journal"));
}

constexpr fs::perms kReadOnlyFile = fs::perms::owner_read | fs::perms::group_read | fs::perms::others_read;
constexpr fs::perms kReadOnlyFolder =
    kReadOnlyFile | fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec;

TEST(Recovery, WorksOnACopyWhereItMayNotWrite) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  cut_off_inside_a_commit(path);
  const std::string file = test::read_raw(path);
  const std::string journal = test::read_raw(folder / "a.mien-journal");
  fs::permissions(path, kReadOnlyFile);
  fs::permissions(folder / "a.mien-journal", kReadOnlyFile);
  fs::permissions(folder.path(), kReadOnlyFolder);
  const mien::test::Folder temporary;
  fs::permissions(temporary.path(), fs::perms::all);
  const int status = run_process([&] {
    // The superuser may write everywhere; somebody else may not.
    if (::geteuid() == 0 && ::setresuid(65534, 65534, 65534) != 0) return 2;
    ::setenv("TMPDIR", temporary.path().c_str(), 1);
    if (::access(folder.path().c_str(), W_OK) == 0) return 3;
    {
      const auto take = Take::open(path);
      if (!take || !take->check()) return 4;
      if (take->path() != path || take->samples().value().size() != 500) return 5;
      if (fs::is_empty(temporary.path())) return 6;
    }
    return fs::is_empty(temporary.path()) ? 0 : 7;
  });
  EXPECT_EQ(status, 0);
  fs::permissions(folder.path(), fs::perms::owner_all);
  EXPECT_EQ(test::read_raw(path), file);
  EXPECT_EQ(test::read_raw(folder / "a.mien-journal"), journal);
}

TEST(Recovery, SaysWhenThereIsNoRoomForTheCopy) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  cut_off_inside_a_commit(path);
  fs::permissions(path, kReadOnlyFile);
  fs::permissions(folder / "a.mien-journal", kReadOnlyFile);
  fs::permissions(folder.path(), kReadOnlyFolder);
  const int status = run_process([&] {
    if (::geteuid() == 0 && ::setresuid(65534, 65534, 65534) != 0) return 2;
    ::setenv("TMPDIR", folder.path().c_str(), 1);
    const auto take = Take::open(path);
    if (take) return 3;
    return take.error().code == ErrorCode::io ? 0 : 4;
  });
  EXPECT_EQ(status, 0);
}

TEST(Recovery, BringsBackATornFirstPage) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  cut_off_inside_a_commit(path);
  std::string bytes = test::read_raw(path);
  bytes.replace(0, 512, std::string(512, '\0'));
  test::write_raw(path, bytes);
  // The journal has it, since deleting rows changes the list of free pages, which begins there.
  EXPECT_EQ(test::read_everything(path), "");
}

TEST(Recovery, NeverFollowsAJournalToOtherFiles) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  cut_off_inside_a_commit(path);
  // A journal may name a file that SQLite then deletes: page number, name, length, sum of its letters, magic.
  const std::string victim = (folder / "precious").string();
  test::write_raw(victim, "keep me");
  std::string journal = test::read_raw(folder / "a.mien-journal");
  const auto put = [&](std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) journal += static_cast<char>(value >> shift & 0xFFU);
  };
  std::uint32_t sum = 0;
  for (const char letter : victim) sum += static_cast<std::uint32_t>(letter);
  put(0x40000000 / 4096 + 1);
  journal += victim;
  put(static_cast<std::uint32_t>(victim.size()));
  put(sum);
  journal += "\xD9\xD5\x05\xF9\x20\xA1\x63\xD7";
  test::write_raw(folder / "a.mien-journal", journal);
  EXPECT_THAT(test::read_everything(path), HasSubstr("move the -journal file away"));
  EXPECT_EQ(test::read_raw(victim), "keep me");
}

TEST(Recovery, IgnoresAJournalOfNothing) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  test::write_example(path);
  for (const std::string_view journal :
       {std::string_view(""), std::string_view("\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", 16)}) {
    test::write_raw(folder / "a.mien-journal", journal);
    EXPECT_EQ(test::read_everything(path), "");
  }
  test::write_raw(folder / "a.mien-journal", std::string(5000, '\x55'));
  EXPECT_EQ(test::read_everything(path), "");
}

TEST(Recovery, KeepsWhatFitsOnAFullDisk) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  const int status = run_process([&] {
    // As a full disk: the file may not grow beyond this.
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {20U << 20U, 20U << 20U};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
    auto writer = TakeWriter::create(path, test::example_header(), false);
    if (!writer) return 3;
    const std::vector<std::byte> packet(60'000, std::byte{7});
    for (int i = 0; i < 1000; ++i) writer->add_entry(test::host_ms(i), "udp", packet);
    const auto status_before = writer->status();
    const auto done = writer->finish();
    if (done || done.error().code != ErrorCode::io) return 4;
    // 60 MB do not pass through a queue of 16 MiB unnoticed.
    if (status_before || status_before.error() != done.error()) return 5;
    if (done.error().message().find("a.mien") == std::string::npos) return 6;
    return done.error().fix.ends_with("what was committed before is kept") ? 0 : 7;
  });
  EXPECT_EQ(status, 0);
  const auto take = Take::open(path);
  ASSERT_TRUE(take) << take.error().message();
  EXPECT_FALSE(take->finished());
  const auto entries = take->entries().value();
  EXPECT_GE(entries.size(), 70U) << "less than the first batch of 4 MiB";
  EXPECT_LT(entries.size(), 340U);
  EXPECT_TRUE(take->check());
}

TEST(Recovery, SaysThatNothingIsKeptOfWhatAppearsWhenFinished) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  const int status = run_process([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {20U << 20U, 20U << 20U};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
    auto writer = TakeWriter::create(path, test::example_header(), false, Appears::when_finished);
    if (!writer) return 3;
    const std::vector<std::byte> packet(60'000, std::byte{7});
    for (int i = 0; i < 1000; ++i) writer->add_entry(test::host_ms(i), "udp", packet);
    const auto done = writer->finish();
    if (done || done.error().code != ErrorCode::io) return 4;
    return done.error().fix.ends_with("nothing of it is kept") ? 0 : 5;
  });
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::is_empty(folder.path())) << "something half-written is left";
  // What is kept is the writer's to say.
  EXPECT_EQ(Database().error(SQLITE_FULL).message(), "the disk is full; free some space");
}

TEST(Recovery, SaysAtOnceWhenNothingCanBeWritten) {
  const mien::test::Folder folder;
  const auto path = folder / "a.mien";
  const int status = run_process([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {8192, 8192};
    if (::setrlimit(RLIMIT_FSIZE, &limit) != 0) return 2;
    const auto writer = TakeWriter::create(path, test::example_header(), false);
    return writer ? 3 : writer.error().code == ErrorCode::io ? 0 : 4;
  });
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(fs::is_empty(folder.path())) << "something half-written is left";
}

}  // namespace
}  // namespace mien::take::recovery_test
