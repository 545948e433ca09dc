#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "tests/project_path.h"

namespace mien::app::test::study_live_test {
namespace {

// The smallest study that there is; what it measures, the study's own tests say.
TEST(StudyLiveCommand, LeavesAPageATableAndFigures) {
  const mien::test::Folder folder;
  const std::string live = project_path("models/live.safetensors");
  const test::Outcome done = test::run({"study", "live", "--rows", "lab", "seen", "--performers", "1",
                                        "--seconds", "2", "--steps", "1", "--model", "twin=" + live,
                                        "--takes", folder / "none.csv", "--out", folder / "live", "--json"});
  ASSERT_EQ(done.status, 0) << done.err;
  EXPECT_NE(done.err.find("none.csv is not here"), std::string::npos) << done.err;

  EXPECT_EQ(std::filesystem::status(folder / "live").permissions(), std::filesystem::perms::owner_all);

  const auto json = nlohmann::json::parse(done.out);
  EXPECT_EQ(json, nlohmann::json::parse(test::content(folder / "live/live.json")));
  EXPECT_EQ(json.at("skipped").size(), 1U);
  ASSERT_EQ(json.at("sets").size(), 1U);
  const auto& rows = json.at("sets")[0].at("rows");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("condition"), "lab");
  const auto& methods = rows[0].at("methods");
  ASSERT_EQ(methods.size(), 7U);
  EXPECT_EQ(methods[1].at("name"), "twin");
  EXPECT_EQ(methods[1].at("pve_mm"), methods[0].at("pve_mm"));
  EXPECT_GT(methods[0].at("pve_mm").at("mean"), 0.1);
  EXPECT_TRUE(methods[6].at("jitter_ratio").is_null()) << "the bound";

  EXPECT_NE(test::content(folder / "live/live.txt").find("lab profile (1 performer, 2 s"), std::string::npos);
  EXPECT_NE(test::content(folder / "live/live.html").find("Where the sensors are"), std::string::npos);
}

}  // namespace
}  // namespace mien::app::test::study_live_test
