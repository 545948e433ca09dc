// `mien align` and `mien personalise --truth` from outside: a take with a phone in, a time and a model out.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace mien::app::test::align_test {
namespace {

using ::testing::HasSubstr;

class AlignProgram : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new Folder;
    const Outcome made = run({"perform", "--script", "reading", "--seconds", "40", "--seed", "3", "--phone",
                              "--take", *folder_ / "take.mien", "--json"});
    ASSERT_EQ(made.status, 0) << made.err;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  /// One line, which is returned.
  static std::string refused(const std::vector<std::string>& arguments) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << joined(arguments) << outcome.err;
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
    return outcome.err;
  }
  static Folder* folder_;
};
Folder* AlignProgram::folder_ = nullptr;

TEST_F(AlignProgram, FindsTheTimeOfAPhoneInATakeAndOfItsFile) {
  const std::string take = *folder_ / "take.mien";
  const Outcome own = run({"align", take, "--out", *folder_ / "truth.csv", "--json"});
  ASSERT_EQ(own.status, 0) << own.err;
  const auto found = nlohmann::json::parse(own.out);
  EXPECT_GT(found["agreement"].get<double>(), 0.3);
  EXPECT_LT(found["offset_sigma_ms"].get<double>(), 10);
  EXPECT_GE(found["blocks"].size(), 4U);
  EXPECT_EQ(found["first_guess"], "arrivals");
  // What it told, at the take's frames, is a file of a phone that began with them.
  const Outcome file = run({"align", take, *folder_ / "truth.csv", "--json"});
  ASSERT_EQ(file.status, 0) << file.err;
  EXPECT_LT(std::abs(nlohmann::json::parse(file.out)["offset_ms"].get<double>()), 15);
  const Outcome people = run({"align", take});
  EXPECT_THAT(people.out, HasSubstr("agreement"));
}

TEST_F(AlignProgram, ReadsTheCalibratedFileBesideTheOneThatIsNamed) {
  const std::string take = *folder_ / "take.mien", named = *folder_ / "slate.csv",
                    calibrated = *folder_ / "slate_cal.csv";
  ASSERT_EQ(run({"align", take, "--out", calibrated}).status, 0);
  std::filesystem::copy_file(calibrated, named);
  const Outcome beside = run({"align", take, named, "--json"});
  ASSERT_EQ(beside.status, 0) << beside.err;
  EXPECT_THAT(beside.err, HasSubstr("slate_cal.csv"));
  EXPECT_EQ(nlohmann::json::parse(beside.out)["first_guess"], "none");
  EXPECT_EQ(run({"align", take, named, "--raw"}).err, "");
  EXPECT_EQ(run({"align", take, calibrated}).err, "");
  // It is the calibrated one that is read, and the other with --raw.
  std::ofstream(calibrated) << "nothing";
  EXPECT_THAT(refused({"align", take, calibrated}), HasSubstr("slate_cal.csv"));
  EXPECT_EQ(run({"align", take, named}).status, 2);
  EXPECT_EQ(run({"align", take, named, "--raw"}).status, 0);
}

TEST_F(AlignProgram, LearnsAWearerWhoIsThenSolvedOtherwise) {
  const std::string take = *folder_ / "take.mien", model = *folder_ / "me.safetensors";
  const Outcome learnt = run({"personalise", take, "--truth", "phone", "--out", model, "--json"});
  ASSERT_EQ(learnt.status, 0) << learnt.err;
  const auto told = nlohmann::json::parse(learnt.out);
  EXPECT_LT(told["mse_after"].get<double>(), told["mse_before"].get<double>());
  EXPECT_GT(told["seconds"].get<double>(), 20);
  const auto hash = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"solve", take, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome solved = run(arguments);
    EXPECT_EQ(solved.status, 0) << solved.err;
    return nlohmann::json::parse(solved.out)["hash"].get<std::string>();
  };
  EXPECT_EQ(hash({"--model", model}), hash({"--model", model}));
  EXPECT_NE(hash({"--model", model}), hash({}));
  EXPECT_THAT(refused({"personalise", take, "--truth", "phone", "--out", model}), HasSubstr("--force"));
}

TEST_F(AlignProgram, SaysWhatIsWrong) {
  const Outcome alone =
      run({"perform", "--script", "free", "--seconds", "12", "--take", *folder_ / "alone.mien"});
  ASSERT_EQ(alone.status, 0) << alone.err;
  EXPECT_THAT(refused({"align", *folder_ / "alone.mien"}), HasSubstr("no phone was recorded"));
  EXPECT_THAT(refused({"align", *folder_ / "take.mien", *folder_ / "nothing.csv"}), HasSubstr("nothing.csv"));
  // Another performer's file. (One who reads the same text at the same pace may well agree.)
  const Outcome other = run({"perform", "--script", "free", "--seconds", "40", "--seed", "4", "--phone",
                             "--take", *folder_ / "other.mien"});
  ASSERT_EQ(other.status, 0) << other.err;
  ASSERT_EQ(run({"align", *folder_ / "other.mien", "--out", *folder_ / "other.csv"}).status, 0);
  EXPECT_THAT(refused({"align", *folder_ / "take.mien", *folder_ / "other.csv"}), HasSubstr("agree"));
  EXPECT_THAT(refused({"personalise", *folder_ / "take.mien", "--truth", *folder_ / "other.csv", "--out",
                       *folder_ / "x.safetensors"}),
              HasSubstr("agree"));
  EXPECT_FALSE(std::filesystem::exists(*folder_ / "x.safetensors"));
}

}  // namespace
}  // namespace mien::app::test::align_test
