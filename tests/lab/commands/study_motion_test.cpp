#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "mien/face/livelink_csv.h"
#include "tests/app/program.h"
#include "tests/virtual/three_sensors.h"

namespace mien::app::test::study_motion_test {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct StudyMotion : public ::testing::Test {
  StudyMotion() {
    write(folder / "talking.csv",
          face::format_livelink_csv(face::livelink_from_motion(virt::test::talking(240))));
    write(folder / "one_frame.csv",
          face::format_livelink_csv(face::livelink_from_motion(virt::test::talking(1))));
    write(folder / "garbage.csv", "Timecode,BlendshapeCount\nyes,\xFF\xFE,no\n");
    write(folder / "garbage.mien", "SQLite format 3");
  }
  Folder folder;
};

TEST_F(StudyMotion, PutsCurvesTakesAndVirtualPerformersSideBySide) {
  write(folder / "rig.toml", virt::test::kRig);
  const Outcome performed =
      run({"perform", "--rig", folder / "rig.toml", "--devices", "lab", "--prologue", "none", "--motion",
           folder / "talking.csv", "--take", folder / "performed.mien"});
  ASSERT_EQ(performed.status, 0) << performed.err;
  const std::vector<std::string> both = {"study", "motion", folder / "talking.csv",
                                         folder / "performed.mien"};

  const Outcome table = run(both);
  ASSERT_EQ(table.status, 0) << table.err;
  EXPECT_EQ(table.err, "");
  EXPECT_THAT(table.out, ContainsRegex("\nagreement of correlations with talking +1\\.00"));
  EXPECT_THAT(table.out, HasSubstr("\njawOpen "));

  std::vector<std::string> more = both;
  more.insert(more.end(), {"--performers", "1", "--seconds", "4", "--json"});
  const Outcome object = run(more);
  ASSERT_EQ(object.status, 0) << object.err;
  const auto json = nlohmann::json::parse(object.out);
  ASSERT_EQ(json.at("motions").size(), 8U) << "two files and six kinds of virtual performance";
  const auto& curve = json.at("motions")[0];
  const auto& take = json.at("motions")[1];
  EXPECT_EQ(curve.at("name"), "talking");
  EXPECT_NEAR(curve.at("seconds"), 4, 0.1);
  EXPECT_NEAR(curve.at("agreement")[1], 1, 0.01) << "the take is of the same motion";
  const double deviation = curve.at("shapes").at("jawOpen").at("deviation");
  EXPECT_GT(deviation, 0.01);
  EXPECT_NEAR(take.at("shapes").at("jawOpen").at("deviation"), deviation, 0.1 * deviation);
  EXPECT_EQ(json.at("motions")[2].at("name"), "range_of_motion");
  EXPECT_EQ(json.at("motions")[7].at("name"), "training");
}

TEST_F(StudyMotion, SaysInALineWhatCannotBeRead) {
  for (const char* name : {"none.csv", "none.mien", "garbage.csv", "garbage.mien", "one_frame.csv"}) {
    const Outcome refused = run({"study", "motion", folder / "talking.csv", folder / name});
    EXPECT_EQ(refused.status, 2) << name;
    EXPECT_EQ(refused.out, "") << name;
    EXPECT_THAT(refused.err, StartsWith("mien: "));
    EXPECT_THAT(refused.err, HasSubstr(name));
    EXPECT_EQ(std::ranges::count(refused.err, '\n'), 1) << refused.err;
  }
  const Outcome nothing = run({"study", "motion"});
  EXPECT_EQ(nothing.status, 2);
  EXPECT_THAT(nothing.err, HasSubstr("files"));
}

}  // namespace
}  // namespace mien::app::test::study_motion_test
