#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "mien/face/livelink_csv.h"
#include "tests/app/program.h"
#include "tests/performer/talking.h"

namespace mien::app::test::study_trackers_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

std::string livelink(const face::Motion& motion) {
  return face::format_livelink_csv(face::livelink_from_motion(motion));
}

/// Six seconds of a truth, and of who told it late, at half its rate and with a gap.
struct StudyTrackersCommand : public ::testing::Test {
  StudyTrackersCommand() {
    const face::Motion truth = performer::test::talking(360);
    write(folder / "truth.csv", livelink(truth));
    face::Motion late = truth;
    late.frames.clear();
    for (int f = 0; f < 180; ++f) {
      face::MotionFrame& frame = late.frames.emplace_back();
      frame = truth.frames[static_cast<std::size_t>(std::max(0, 2 * f - 6))];
      frame.time_s = f / 30.0;
      frame.has_face = f < 90 || f >= 105;
    }
    write(folder / "late.csv", livelink(late));
    std::string scores = "timestamp_ms,jawOpen\n";
    for (int f = 0; f < 360; ++f)
      scores += std::to_string(f * 1000 / 60.0) + "," +
                std::to_string(truth.frames[static_cast<std::size_t>(f)].weights[face::shape("jawOpen")]) +
                "\n";
    write(folder / "scores.csv", scores);
    write(folder / "unknown.csv", "time_s,jawOpn\n0,1\n");
    write(folder / "garbage.txt", "this is no recording\n");
  }
  [[nodiscard]] std::vector<std::string> with(const std::vector<std::string>& curves,
                                              const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"study", "trackers", "--truth", folder / "truth.csv", "--curves"};
    words.insert(words.end(), curves.begin(), curves.end());
    words.insert(words.end(), {"--out", folder / "out"});
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  Folder folder;
};

TEST_F(StudyTrackersCommand, ComparesRecordingsOnOneTimeLine) {
  const Outcome done = run(with({"late=" + folder / "late.csv", "jaw=" + folder / "scores.csv"}, {"--json"}));
  ASSERT_EQ(done.status, 0) << done.err;
  const auto json = nlohmann::json::parse(done.out);
  EXPECT_EQ(json, nlohmann::json::parse(content(folder / "out/trackers.json")));
  EXPECT_EQ(json.at("modelled"), false);
  ASSERT_EQ(json.at("rows").size(), 1U);
  const auto& trackers = json.at("rows")[0].at("trackers");
  ASSERT_EQ(trackers.size(), 2U);
  EXPECT_NEAR(trackers[0].at("lag_ms").at("mean"), 100, 8);
  EXPECT_NEAR(trackers[0].at("gap_share").at("mean"), 15.0 / 180, 0.02);
  EXPECT_LT(trackers[0].at("pve_without_lag_mm").at("mean"), trackers[0].at("pve_seen_mm").at("mean"));
  EXPECT_EQ(trackers[1].at("told_shapes"), 1);
  EXPECT_LT(trackers[1].at("mse_held").at("mean"), 1e-4);
  EXPECT_GT(trackers[1].at("pve_whole_mm").at("mean"), trackers[1].at("pve_held_mm").at("mean"));
  EXPECT_EQ(std::filesystem::status(folder / "out").permissions(), std::filesystem::perms::owner_all);
  EXPECT_THAT(content(folder / "out/trackers.txt"), HasSubstr("truth.csv"));
  EXPECT_THAT(content(folder / "out/trackers.html"), HasSubstr("Worst moments"));
}

TEST_F(StudyTrackersCommand, MovesRecordings) {
  const std::string late = "late=" + folder / "late.csv";
  const Outcome moved = run(with({late}, {"--offset", "late=-0.1", "--json"}));
  ASSERT_EQ(moved.status, 0) << moved.err;
  const auto json = nlohmann::json::parse(moved.out);
  EXPECT_NEAR(json.at("rows")[0].at("trackers")[0].at("lag_ms").at("mean"), 0, 8);

  const Outcome apart = run(with({late}, {"--offset", "late=1000"}));
  EXPECT_EQ(apart.status, 2);
  EXPECT_THAT(apart.err, HasSubstr("late is from 1000.000 to 1005.967 s"));
  EXPECT_THAT(apart.err, HasSubstr("the truth is from 0.000 to 5.983 s"));
}

/// A recorder that was started 0.3 s before the truth's, beside one that was started with it.
TEST_F(StudyTrackersCommand, HoldsNobodyToWhenHeBeganToRecord) {
  face::Motion small = performer::test::talking(378);
  for (face::MotionFrame& frame : small.frames)
    for (float& weight : frame.weights.values) weight *= 0.8F;
  write(folder / "before.csv", livelink(small));
  face::Motion truth = performer::test::talking(378);
  for (face::Motion* motion : {&small, &truth}) {
    motion->frames.erase(motion->frames.begin(), motion->frames.begin() + 18);
    for (std::size_t f = 0; f < motion->frames.size(); ++f)
      motion->frames[f].time_s = static_cast<double>(f) / 60;
  }
  write(folder / "truth.csv", livelink(truth));
  write(folder / "with.csv", livelink(small));
  const std::vector<std::string> both = {"with=" + folder / "with.csv", "before=" + folder / "before.csv"};
  const auto compared = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome done = run(with(both, words));
    EXPECT_EQ(done.status, 0) << done.err;
    return nlohmann::json::parse(done.out);
  };
  const auto figure = [](const nlohmann::json& json, std::size_t tracker, const char* name) {
    return json.at("rows")[0].at("trackers")[tracker].at(name).at("mean").get<double>();
  };
  const auto apart = compared({});
  EXPECT_NEAR(figure(apart, 1, "lag_ms"), 300, 2);
  for (const char* name : {"pve_held_mm", "pve_whole_mm", "mse_whole"})
    EXPECT_NEAR(figure(apart, 1, name), figure(apart, 0, name), 0.03 * figure(apart, 0, name)) << name;
  EXPECT_EQ(apart.at("offset_unknown"), nlohmann::json::array());
  EXPECT_THAT(content(folder / "out/trackers.html"), HasSubstr("These recordings share no clock."));

  const auto shared = compared({"--shared-clock"});
  for (const char* name : {"pve_held_mm", "pve_whole_mm", "mse_whole"})
    EXPECT_GT(figure(shared, 1, name), 2 * figure(shared, 0, name)) << name;
  EXPECT_NEAR(figure(shared, 1, "lag_ms"), 300, 2);
  EXPECT_THAT(content(folder / "out/trackers.html"), Not(HasSubstr("share no clock")));

  const auto unknown = compared({"--search", "0.1"});
  EXPECT_EQ(unknown.at("offset_unknown"), nlohmann::json::array({"before"}));
  EXPECT_TRUE(unknown.at("rows")[0].at("trackers")[1].at("pve_whole_mm").is_null());
  EXPECT_NEAR(figure(unknown, 0, "pve_whole_mm"), figure(apart, 0, "pve_whole_mm"), 0.01);
  EXPECT_THAT(content(folder / "out/trackers.txt"), HasSubstr("before: how much earlier or later it began"));
}

TEST_F(StudyTrackersCommand, SaysInALineWhatCannotBeCompared) {
  const auto refused = [](const std::vector<std::string>& words, const char* says) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 2) << joined(words);
    EXPECT_EQ(outcome.out, "");
    EXPECT_THAT(outcome.err, StartsWith("mien: "));
    EXPECT_THAT(outcome.err, HasSubstr(says));
    EXPECT_EQ(std::ranges::count(outcome.err, '\n'), 1) << outcome.err;
  };
  const std::string late = "late=" + folder / "late.csv";
  refused(with({"x=" + folder / "unknown.csv"}), "did you mean jawOpen?");
  refused(with({"x=" + folder / "garbage.txt"}), "no recording of a tracker");
  refused(with({"x=" + folder / "none.csv"}), "no such file");
  refused(with({folder / "late.csv"}), "NAME=FILE");
  refused(with({late, late}), "two trackers have one name");
  refused(with({late}, {"--offset", "lat=1"}), "did you mean late?");
  refused(with({late}, {"--offset", "late=soon"}), "NAME=SECONDS");
  refused({"study", "trackers", "--curves", late, "--out", folder / "out"}, "--truth");
  refused({"study", "trackers"}, "--truth is missing");
}

}  // namespace
}  // namespace mien::app::test::study_trackers_test
