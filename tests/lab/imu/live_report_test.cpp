#include "lab/imu/live_study.h"

#include <gmock/gmock.h>

namespace mien::lab::live_report_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

LiveMethod method(std::string name, double pve) {
  LiveMethod out{std::move(name), std::vector<Figures>(2)};
  out.performers[0][0] = pve - 0.1;
  out.performers[1][0] = pve + 0.1;
  return out;
}

LiveSet small() {
  LiveRow seen{.condition = LiveCondition::seen, .title = "seen placement", .frames = 600};
  seen.observed = 0.999;
  seen.rotation_rms_deg = 3.84;
  seen.methods = {method("live", 0.7), method("ridge", 0.9)};
  LiveRow eating{.condition = LiveCondition::eating, .title = "eating <fast>", .frames = 60};
  eating.methods = {method("live", 0.8), method("ridge", 0.85)};
  return {"two <people>", {seen, eating}};
}

TEST(LiveTable, HasAHeadARowAndItsMethods) {
  const measure::Table table = live_table(small());
  EXPECT_EQ(table.strong_rows, (std::vector<std::size_t>{0, 3}));
  ASSERT_EQ(table.rows.size(), 6U);
  EXPECT_EQ(table.rows[0].size(), 1U);
  EXPECT_THAT(table.rows[0][0], HasSubstr("seen placement (2 performers, 10 s, 99.9 % observed, 3.8° off)"));
  ASSERT_EQ(table.rows[1].size(), table.columns.size());
  EXPECT_EQ(table.rows[1][0], "live");
  EXPECT_EQ(table.rows[1][1], "0.700 ± 0.141");
  EXPECT_EQ(table.rows[1][2], "-");
}

TEST(LiveReport, ShowsEachGroupThatWasStudied) {
  const std::string html = live_report({{small()}}, "models").html();
  EXPECT_THAT(html, HasSubstr("What the wearer does: vertex error"));
  EXPECT_THAT(html, HasSubstr("Where the sensors are: vertex error"));
  EXPECT_THAT(html, Not(HasSubstr("A long session: vertex error")));
  EXPECT_THAT(html, HasSubstr("eating &lt;fast&gt;"));
  EXPECT_THAT(html, HasSubstr("vertex error; ridge 0.900"));
  const std::string two = live_report({{small(), small()}}, "models").html();
  EXPECT_THAT(two, HasSubstr("<h2>two &lt;people&gt;</h2>"));
}

}  // namespace
}  // namespace mien::lab::live_report_test
