// Studies by short trainings, where their folder is not theirs alone or the disk is full.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "tests/app/program.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::short_trainings_test {
namespace {

using ::testing::HasSubstr;

/// The smallest ablation.
struct ShortTrainings : public ::testing::Test {
  void SetUp() override {
    if (!std::filesystem::exists(std::filesystem::path(program_path()).parent_path() / "mien-train"))
      GTEST_SKIP() << "no mien-train is built beside mien";
    write(folder / "rig.toml", virt::test::kRig);
    std::filesystem::create_directories(trainings);
  }
  [[nodiscard]] std::vector<std::string> ablation() const {
    return {"study",   "ablation", "--rig", folder / "rig.toml", "--rows", "third_of_people",
            "--quick", "--seeds",  "1",     "--people",          "1",      "--performers",
            "10",      "--steps",  "1",     "--no-shipped",      "--out",  folder / "out"};
  }
  Folder folder;
  std::string trainings = folder / "out/trainings";
};

void expect_one_line(const Outcome& outcome, int status, const std::string& says) {
  EXPECT_EQ(outcome.status, status);
  EXPECT_EQ(outcome.out, "");
  // Progress stands before it.
  const std::string line = outcome.err.substr(outcome.err.rfind("mien: "));
  EXPECT_EQ(std::ranges::count(line, '\n'), 1) << outcome.err;
  EXPECT_THAT(line, HasSubstr(says));
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

TEST_F(ShortTrainings, AFullDiskIsOneLineAndLeavesNothingHalfWritten) {
  // A limit on the size of files stands for the disk: 100 blocks of 512 bytes, and no signal for who exceeds
  // it.
  std::string line = "ulimit -f 100; trap '' XFSZ; exec " + program_path();
  for (const std::string& word : ablation()) line += " " + word;
  Outcome outcome;
  const int status = std::system((line + " > " + folder / "said.out" + " 2> " + folder / "said.err").c_str());
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.out = content(folder / "said.out");
  outcome.err = content(folder / "said.err");
  expect_one_line(outcome, 1, "File too large");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "out"))
    EXPECT_TRUE(entry.is_directory() || entry.path().filename() == "lock" ||
                entry.path().filename() == "trainer.sha256")
        << entry.path();
}

}  // namespace
}  // namespace mien::app::test::short_trainings_test
