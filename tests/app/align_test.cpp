// `mien align` and `mien personalise --truth` from outside: a take with a phone in, a time and a model out.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "mien/core/files.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/core/wav.h"
#include "mien/take/take.h"
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

/// A phone's file and its film: what the take's phone told and heard from `from_s` on, by the sensors' time.
class PhonesFiles {
 public:
  PhonesFiles(const Folder& folder, double from_s) : folder_(folder) {
    const std::string take = folder / "take.mien";
    if (run({"align", take, "--out", folder / "whole.csv"}).status != 0) return;
    std::istringstream whole(content(folder / "whole.csv"));
    std::string rows, line;
    for (double row = -1; std::getline(whole, line); ++row)
      if (row < 0 || row / 60 >= from_s) rows += line + '\n';
    write(csv(), rows);
    const auto recorded = take::Take::open(take).value();
    const take::Audio audio = recorded.audio().value().value();
    const double later_s = to_seconds(audio.start - recorded.ticks().value().front().frame) - from_s;
    Random random(1);
    sound_.rate_hz = static_cast<std::uint32_t>(audio.rate_hz);
    const auto before = static_cast<std::ptrdiff_t>(std::lround(later_s * audio.rate_hz));
    for (std::ptrdiff_t i = -before; i < static_cast<std::ptrdiff_t>(audio.samples.size()); ++i)
      sound_.samples.push_back(static_cast<float>(
          (i < 0 ? 0 : 0.3 * double{audio.samples[static_cast<std::size_t>(i)]}) + random.normal(0, 0.005)));
  }
  [[nodiscard]] std::string csv() const { return folder_ / "Slate_1.csv"; }
  /// With pictures, beside the file.
  [[nodiscard]] std::string film(const Sound& sound) const {
    EXPECT_TRUE(write_file(folder_ / "film.wav", format_wav(sound)));
    const std::string film = folder_ / "Slate_1.mov";
    const int pictures = static_cast<int>(30 * sound.duration_s()) + 1;
    const std::string command = "head -c " + std::to_string(pictures * 16 * 16 * 3) + " /dev/zero | " +
                                helper() + " video --size 16x16 --fps 30 --audio " + (folder_ / "film.wav") +
                                " --out " + film;
    EXPECT_EQ(std::system(command.c_str()), 0);
    return film;
  }
  [[nodiscard]] const Sound& sound() const { return sound_; }
  static std::string helper() {
    return (std::filesystem::path(program_path()).parent_path() / "mien-media").string();
  }

 private:
  const Folder& folder_;
  Sound sound_;
};

TEST_F(AlignProgram, AFilmsSoundIsTheFirstGuess) {
  if (!std::filesystem::exists(PhonesFiles::helper())) GTEST_SKIP() << "built without mien-media";
  constexpr double kFromS = 6;
  const std::string take = *folder_ / "take.mien";
  const PhonesFiles phone(*folder_, kFromS);
  ASSERT_GT(phone.sound().duration_s(), 20);
  const auto aligned = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"align", take, phone.csv(), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return std::pair(nlohmann::json::parse(outcome.out), outcome.err);
  };
  EXPECT_EQ(aligned({}).first["first_guess"], "none");
  const std::string film = phone.film(phone.sound());
  const auto [found, said] = aligned({});
  EXPECT_EQ(said, "");
  EXPECT_EQ(found["first_guess"], "sound");
  const nlohmann::json& sound = found["sound"];
  EXPECT_NEAR(sound["offset_ms"].get<double>(), 1e3 * kFromS, 3);
  EXPECT_GT(sound["score"].get<double>(), 1.3);
  EXPECT_FALSE(sound["by_timecode"].get<bool>());
  // The file is the phone's as it was aligned: its lag is gone.
  EXPECT_NEAR(sound["motion_after_sound_ms"].get<double>(), 0, 25);
  EXPECT_NEAR(found["offset_ms"].get<double>(), aligned({"--no-sound"}).first["offset_ms"].get<double>(), 1);
  EXPECT_THAT(run({"align", take, phone.csv()}).out, HasSubstr("first guess what both heard"));
  EXPECT_TRUE(aligned({"--no-sound"}).first["sound"].is_null());
  EXPECT_EQ(aligned({"--film", *folder_ / "film.wav"}).first["first_guess"], "sound");

  // A film beside the file that is of no use is said in a line; one that was named is an error.
  const auto without = [&](const std::string& what) {
    const auto [json, line] = aligned({});
    EXPECT_EQ(json["first_guess"], "none");
    EXPECT_TRUE(json["sound"].is_null());
    EXPECT_EQ(std::ranges::count(line, '\n'), 1) << line;
    EXPECT_THAT(line, HasSubstr("Slate_1.mov: "));
    EXPECT_THAT(line, HasSubstr(what));
  };
  Sound brief = phone.sound();
  brief.samples.resize(std::size_t{3} * brief.rate_hz);
  (void)phone.film(brief);
  without("3.0 s long");
  Sound other = phone.sound();
  std::ranges::reverse(other.samples);
  (void)phone.film(other);
  without("do not match");
  write(film, "ffconcat version 1.0\nfile film.wav\n");
  without("it is no film");
  EXPECT_THAT(refused({"align", take, phone.csv(), "--film", film}), HasSubstr("it is no film"));
  EXPECT_THAT(refused({"align", take, phone.csv(), "--film", *folder_ / "none.mov"}),
              HasSubstr("no such film"));
  EXPECT_THAT(refused({"align", take, "--film", film}), HasSubstr("--film"));
  std::filesystem::remove(film);

  // A take of nobody who is heard.
  const std::string mute = *folder_ / "mute.mien";
  ASSERT_EQ(run({"perform", "--script", "reading", "--voice", "babble", "--seconds", "40", "--seed", "3",
                 "--phone", "--take", mute})
                .status,
            0);
  ASSERT_EQ(run({"align", mute, "--out", *folder_ / "mute.csv"}).status, 0);
  const Outcome outcome =
      run({"align", mute, *folder_ / "mute.csv", "--film", *folder_ / "film.wav", "--json"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("the take has no sound"));
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
  // Prompts of a take that is measured do not drop it.
  const std::string prompted = *folder_ / "prompted.mien";
  const Outcome made =
      run({"perform", "--script", "free", "--seconds", "6", "--prologue", "full", "--take", prompted});
  ASSERT_EQ(made.status, 0) << made.err;
  const auto evaluated = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"evaluate", prompted, "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome done = run(arguments);
    EXPECT_EQ(done.status, 0) << done.err;
    return nlohmann::json::parse(done.out, nullptr, false);
  };
  const auto by_phone = evaluated({"--model", model});
  EXPECT_EQ(by_phone["adapted"], false);
  EXPECT_EQ(by_phone["model"]["mse"], evaluated({"--model", model, "--no-adapt"})["model"]["mse"]);
  EXPECT_NE(by_phone["model"]["mse"], evaluated({"--no-adapt"})["model"]["mse"]);
  EXPECT_THAT(refused({"personalise", take, "--truth", "phone", "--out", model}), HasSubstr("--force"));
}

TEST_F(AlignProgram, MeasuresAgainstWhatAPhoneTold) {
  const std::string take = *folder_ / "take.mien", csv = *folder_ / "beside.csv";
  ASSERT_EQ(run({"align", take, "--out", csv}).status, 0);
  const auto measured = [](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "evaluate");
    arguments.emplace_back("--json");
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out, nullptr, false);
  };
  const auto own = measured({take}), told = measured({take, "--truth", "phone"}),
             file = measured({take, "--truth", csv});
  EXPECT_EQ(own["truth"], "own");
  EXPECT_TRUE(own["told"].empty());
  EXPECT_EQ(told["truth"], "told");
  ASSERT_EQ(told["told"].size(), 1U);
  EXPECT_EQ(told["told"][0]["by"], "phone");
  EXPECT_GT(told["told"][0]["agreement"].get<double>(), 0.3);
  EXPECT_GT(told["told"][0]["known_s"].get<double>(), 30);
  EXPECT_EQ(file["told"][0]["by"], "beside.csv");
  // The same face, measured by a phone that errs a little.
  const auto pve = [](const nlohmann::json& of) { return of["model"]["pve_mm"]["mean"].get<double>(); };
  EXPECT_NE(pve(told), pve(own));
  EXPECT_NEAR(pve(told), pve(own), 0.3 * pve(own));
  EXPECT_NEAR(pve(file), pve(told), 0.1 * pve(told));
  const Outcome people = run({"evaluate", take, "--truth", "phone", "--report", *folder_ / "told.html"});
  EXPECT_THAT(people.out, HasSubstr("was told by phone"));
  EXPECT_THAT(content(*folder_ / "told.html"), HasSubstr("A phone errs, too"));

  EXPECT_THAT(refused({"evaluate", take, take, "--truth", csv}), HasSubstr("belongs to one take"));
  EXPECT_THAT(refused({"evaluate", take, "--raw"}), HasSubstr("--truth"));
  const std::string alone = *folder_ / "no_phone.mien";
  ASSERT_EQ(run({"perform", "--script", "reading", "--seconds", "5", "--take", alone}).status, 0);
  EXPECT_THAT(refused({"evaluate", alone, "--truth", "phone"}), HasSubstr("no phone was recorded"));
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
