// Studies by short trainings, where their folder is not theirs alone, the disk is full or they are stopped.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <thread>

#include "tests/app/program.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::short_trainings_test {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kNoneTrained =
    "mien: stopped after 0 of 2 trainings; run the study again: it goes on where it was\n";

/// The smallest ablation.
struct ShortTrainings : public ::testing::Test {
  void SetUp() override {
    if (!std::filesystem::exists(std::filesystem::path(program_path()).parent_path() / "mien-train"))
      GTEST_SKIP() << "no mien-train is built beside mien";
    write(folder / "rig.toml", virt::test::kRig);
    std::filesystem::create_directories(trainings);
  }
  [[nodiscard]] std::vector<std::string> ablation(const std::vector<std::string>& how_much = {
                                                      "--quick", "--steps", "1"}) const {
    std::vector<std::string> all = {
        "study",       "ablation", "--rig", folder / "rig.toml", "--rows", "third_of_people", "--seeds",
        "1",           "--people", "1",     "--performers",      "10",     "--no-shipped",    "--out",
        folder / "out"};
    all.insert(all.end(), how_much.begin(), how_much.end());
    return all;
  }
  [[nodiscard]] pid_t start_study(const std::vector<std::string>& arguments) const {
    return start(arguments, folder / "said.out", folder / "said.err");
  }
  [[nodiscard]] Outcome outcome_of(int status) const {
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), content(folder / "said.out"),
            content(folder / "said.err")};
  }
  /// What Ctrl-C makes of a study at work.
  [[nodiscard]] Outcome interrupted(pid_t study) const {
    int status = 0;
    ::kill(study, SIGINT);
    ::waitpid(study, &status, 0);
    return outcome_of(status);
  }
  /// The quick one, where a limit on the size of files stands for the disk: in blocks of 512 bytes, and no
  /// signal for who exceeds it.
  [[nodiscard]] Outcome on_a_disk_of(int blocks) const {
    std::string line = "ulimit -f " + std::to_string(blocks) + "; trap '' XFSZ; exec " + program_path();
    for (const std::string& word : ablation()) line += " " + word;
    line += " > " + folder / "said.out" + " 2> " + folder / "said.err";
    return outcome_of(std::system(line.c_str()));
  }
  /// Of the trainings' folder.
  [[nodiscard]] std::vector<std::string> files_ending_with(std::string_view ending) const {
    std::vector<std::string> out;
    std::error_code code;
    for (const auto& entry : std::filesystem::directory_iterator(trainings, code))
      if (entry.path().string().ends_with(ending)) out.push_back(entry.path().string());
    return out;
  }
  Folder folder;
  std::string trainings = folder / "out/trainings";
};

void expect_one_line(const Outcome& outcome, int status, const std::string& says) {
  EXPECT_EQ(outcome.status, status);
  EXPECT_EQ(outcome.out, "");
  // Progress stands before it.
  const std::size_t begin = outcome.err.rfind("mien: ");
  ASSERT_NE(begin, std::string::npos) << outcome.err;
  const std::string line = outcome.err.substr(begin);
  EXPECT_EQ(std::ranges::count(line, '\n'), 1) << outcome.err;
  EXPECT_THAT(line, HasSubstr(says));
}

/// Waits for something that a process does, and is false where it ends without.
template <class Done>
bool wait_until(pid_t process, const Done& done) {
  while (!done()) {
    if (::waitpid(process, nullptr, WNOHANG) != 0) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

/// Whether a process hears a signal, rather than being ended by it.
bool hears(pid_t process, int signal) {
  const std::string status = content("/proc/" + std::to_string(process) + "/status"), key = "SigCgt:";
  const std::size_t at = status.find(key);
  return at != std::string::npos &&
         (std::strtoull(status.c_str() + at + key.size(), nullptr, 16) >> (signal - 1) & 1U) != 0;
}

/// How many trainers work for a study.
int trainers_of(pid_t study) {
  const std::string parent = std::string("--parent") + '\0' + std::to_string(study) + '\0';
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream in(entry.path() / "cmdline");
    std::string command;
    std::getline(in, command);  // A process that has just ended cannot be read, and is none.
    if (command.find("mien-train") != std::string::npos && command.find(parent) != std::string::npos) ++count;
  }
  return count;
}

TEST_F(ShortTrainings, TwoStudiesDoNotShareAFolder) {
  const int other = ::open((trainings + "/lock").c_str(), O_CREAT | O_RDWR, 0600);
  ASSERT_GE(other, 0);
  ASSERT_EQ(::flock(other, LOCK_EX | LOCK_NB), 0);
  expect_one_line(run(ablation()), 1, "another study is at work in this folder");
  ::close(other);
}

TEST_F(ShortTrainings, ModelsOfAnotherBuildAreNotMixedIn) {
  write(trainings + "/trainer.sha256", "of another build\n");
  expect_one_line(run(ablation()), 2, "another build of the trainer");
  EXPECT_EQ(content(trainings + "/trainer.sha256"), "of another build\n");
}

TEST_F(ShortTrainings, ModelsOfAnUnknownBuildAreNotMixedIn) {
  for (const char* name :
       {"/base-1-0123456789ab.safetensors", "/base-1-0123456789ab.safetensors.checkpoint"}) {
    write(trainings + name, "of an unknown build\n");
    expect_one_line(run(ablation()), 2, "an unknown build of the trainer");
    EXPECT_EQ(content(trainings + name), "of an unknown build\n");
    EXPECT_FALSE(std::filesystem::exists(trainings + "/trainer.sha256"));
    std::filesystem::remove(trainings + name);
  }
}

TEST_F(ShortTrainings, AFullDiskIsOneLineAndLeavesNothingHalfWritten) {
  expect_one_line(on_a_disk_of(100), 1, "File too large");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "out"))
    EXPECT_TRUE(entry.is_directory() || entry.path().filename() == "lock" ||
                entry.path().filename() == "trainer.sha256")
        << entry.path();
}

TEST_F(ShortTrainings, AFullDiskOfATrainerIsItsLine) {
  // 3 MiB: what is performed has 2.4 MB at most, a checkpoint 4.1.
  const Outcome outcome = on_a_disk_of(6144);
  expect_one_line(outcome, 1,
                  "File too large; nothing was written; run the study again: it goes on where it was");
  EXPECT_THAT(
      outcome.err,
      ContainsRegex("mien: (base|third_of_people)-1: mien-train: [^\n]*\\.checkpoint: File too large"));
  for (const char* ending : {".checkpoint", ".part", ".csv"})
    EXPECT_THAT(files_ending_with(ending), testing::IsEmpty());
  // What is performed stays for the next, and is all that there is.
  EXPECT_THAT(
      files_ending_with(".safetensors"),
      testing::AllOf(testing::Not(testing::IsEmpty()), testing::Each(StartsWith(trainings + "/data-"))));
}

TEST_F(ShortTrainings, AStopWhilePeoplePerformSaysHowToGoOn) {
  const pid_t study = start_study(ablation());
  ASSERT_GT(study, 0);
  // It listens from when the first are about to perform.
  ASSERT_TRUE(wait_until(study, [&] { return hears(study, SIGINT); })) << content(folder / "said.err");
  expect_one_line(interrupted(study), 1, kNoneTrained);
}

TEST_F(ShortTrainings, CtrlCLeavesCheckpointsThatTheNextGoesOnFromAndNoTrainer) {
  // Long enough to be met at work.
  const std::vector<std::string> arguments = ablation({"--steps", "40"});
  const pid_t study = start_study(arguments);
  ASSERT_GT(study, 0);
  ASSERT_TRUE(wait_until(study, [&] { return !files_ending_with(".checkpoint").empty(); }))
      << content(folder / "said.err");
  EXPECT_GT(trainers_of(study), 0);
  expect_one_line(interrupted(study), 1, kNoneTrained);
  EXPECT_EQ(trainers_of(study), 0);
  EXPECT_FALSE(files_ending_with(".checkpoint").empty());
  EXPECT_THAT(files_ending_with(".part"), testing::IsEmpty());
  std::map<std::string, std::string> curves;
  for (const std::string& path : files_ending_with(".csv")) curves[path] = content(path);
  EXPECT_FALSE(curves.empty());

  const Outcome next = run(arguments);
  ASSERT_EQ(next.status, 0) << next.err;
  EXPECT_THAT(files_ending_with(".checkpoint"), testing::IsEmpty());
  // Their seconds tell them from those of a training that began anew.
  for (const auto& [path, curve] : curves) EXPECT_THAT(content(path), StartsWith(curve));
}

}  // namespace
}  // namespace mien::app::test::short_trainings_test
