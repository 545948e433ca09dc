// `mien dataset` from outside: takes in; a list, a splits file and windows with their datasheet out.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::dataset_test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

class DatasetProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    std::filesystem::create_directory(takes());
    for (const char* seed : {"3", "4", "5"}) {
      const Outcome made = run({"perform", "--script", "free", "--seconds", "12", "--seed", seed, "--take",
                                takes() + "/" + seed + ".mien"});
      ASSERT_EQ(made.status, 0) << made.err;
    }
    write(takes() + "/foreign.mien", "\x1b[2Jnot a take");
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static std::string takes() { return *folder_ / "takes"; }
  static Json json_of(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << joined(arguments) << outcome.err;
    return Json::parse(outcome.out, nullptr, false);
  }
  /// One line, which is returned.
  static std::string refused(const std::vector<std::string>& arguments) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << joined(arguments) << outcome.err;
    EXPECT_TRUE(outcome.out.empty()) << outcome.out;
    const std::size_t line = outcome.err.find("mien: ");
    EXPECT_NE(line, std::string::npos) << outcome.err;
    if (line == std::string::npos) return {};
    EXPECT_EQ(std::count(outcome.err.begin() + static_cast<std::ptrdiff_t>(line), outcome.err.end(), '\n'),
              1);
    return outcome.err.substr(line);
  }
  static Folder* folder_;
};
Folder* DatasetProgram::folder_ = nullptr;

TEST_F(DatasetProgram, ListsWhatAFolderHolds) {
  const Json told = json_of({"dataset", takes()});
  EXPECT_EQ(told["people"].size(), 3U);
  EXPECT_EQ(told["people"][0]["name"], "virtual:3");
  EXPECT_EQ(told["takes"].size(), 3U);
  EXPECT_EQ(told["takes"][0]["truth"], "own");
  EXPECT_GT(told["takes"][0]["seconds"]["counted_s"].get<double>(), 10);
  EXPECT_GT(told["seconds"]["before_calibration_s"].get<double>(), 10);
  EXPECT_EQ(told["shapes"].size(), 53U);
  EXPECT_GT(told["shapes"]["eyeBlink_L"][1].get<double>(), 0.5);
  EXPECT_EQ(told["left_out"][0]["file"], "foreign.mien");
  const Outcome people = run({"dataset", takes()});
  EXPECT_EQ(people.status, 0) << people.err;
  for (const char* shown : {"3 people, 3 takes", "virtual:4", "jawOpen", "before the calibration was over",
                            "foreign.mien: this is not a take"})
    EXPECT_THAT(people.out, HasSubstr(shown));
  EXPECT_EQ(people.out.find('\x1b'), std::string::npos);
}

TEST_F(DatasetProgram, SplitsByPersonAndExportsWindows) {
  const std::string splits = *folder_ / "splits.toml", out = *folder_ / "windows";
  const Json drawn = json_of({"dataset", "split", takes(), "--out", splits, "--seed", "2"});
  for (const char* set : {"train", "validation", "test"}) EXPECT_EQ(drawn["split"][set].size(), 1U) << set;
  EXPECT_THAT(refused({"dataset", "split", takes(), "--out", splits}), HasSubstr("--force"));
  const Json exported = json_of({"dataset", "export", takes(), "--splits", splits, "--out", out});
  for (const char* set : {"train", "validation", "test"}) {
    EXPECT_EQ(exported["sets"][set]["people"], drawn["split"][set]);
    EXPECT_GT(exported["sets"][set]["windows"].get<int>(), 5);
    EXPECT_TRUE(std::filesystem::exists(out + "/" + set + ".safetensors"));
  }
  EXPECT_THAT(content(out + "/datasheet.md"), HasSubstr("mien dataset export " + takes()));
  EXPECT_THAT(refused({"dataset", "export", takes(), "--splits", splits, "--out", out}),
              HasSubstr("--force"));
  const Json fewer =
      json_of({"dataset", "export", takes(), "--splits", splits, "--out", out, "--stride", "240", "--force"});
  EXPECT_LT(fewer["sets"]["train"]["windows"], exported["sets"]["train"]["windows"]);
}

TEST_F(DatasetProgram, SaysThatFewPeopleAreTooFew) {
  const std::string few = *folder_ / "few";
  std::filesystem::create_directory(few);
  for (const char* take : {"3.mien", "4.mien"})
    std::filesystem::copy_file(takes() + "/" + take, few + "/" + take);
  const Outcome two = run({"dataset", "split", few, "--out", *folder_ / "two.toml"});
  EXPECT_EQ(two.status, 0) << two.err;
  EXPECT_THAT(two.err, HasSubstr("two people are too few"));
}

TEST_F(DatasetProgram, SaysWhatIsWrong) {
  EXPECT_THAT(refused({"dataset"}), HasSubstr("mien dataset FOLDER"));
  EXPECT_THAT(refused({"dataset", *folder_ / "nowhere"}), HasSubstr("there is no such folder"));
  const std::string empty = *folder_ / "empty";
  std::filesystem::create_directory(empty);
  EXPECT_THAT(refused({"dataset", empty}), HasSubstr("no take (*.mien)"));
  EXPECT_THAT(refused({"dataset", "split", takes(), "--out", *folder_ / "s.txt"}), HasSubstr(".toml"));
  EXPECT_THAT(refused({"dataset", "split", takes(), "--out", *folder_ / "s.toml", "--validation", "0.6",
                       "--test", "0.4"}),
              HasSubstr("less than 1"));
  write(*folder_ / "wrong.toml", "[split]\ntrain = [\"virtual:33\"]\n");
  EXPECT_THAT(
      refused({"dataset", "export", takes(), "--splits", *folder_ / "wrong.toml", "--out", *folder_ / "w"}),
      HasSubstr("did you mean virtual:3?"));
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "w"));
}

}  // namespace
}  // namespace mien::app::test::dataset_test
