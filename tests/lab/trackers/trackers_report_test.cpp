#include "lab/trackers/trackers_report.h"

#include <gmock/gmock.h>

#include "mien/builtin_face/builtin_face.h"

namespace mien::lab::trackers_report_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// One second at 2 frames a second, seen by a phone but for its middle.
CurveComparison compared() {
  CurveComparison out;
  out.time_s = {0, 0.5, 1};
  out.truth.resize(3);
  CurveScore& phone = out.scores.emplace_back();
  phone.name = "phone \xC3\xBC";
  phone.told_shapes.set();
  phone.pve_whole_mm = 1.25;
  phone.gap_share = 0.5;
  phone.shown.resize(3);
  phone.saw = {true, false, true};
  phone.pve_mm = {1, 2, 1};
  return out;
}

TEST(TrackerPictures, ShowTheWorstMoment) {
  const CurveComparison comparison = compared();
  const auto moment = worst_moment(comparison);
  ASSERT_TRUE(moment);
  const auto strip = moment_strip(builtin_face::make_builtin(), comparison, *moment);
  ASSERT_TRUE(strip) << strip.error().message();
  EXPECT_GT(strip->width, 3 * 160);
}

TEST(RecordedTrackers, HaveAPage) {
  CurveComparison comparison = compared();
  const std::string html = trackers_report(comparison, "take.mien", "a <test>")->html();
  EXPECT_THAT(html, HasSubstr("1.25 mm"));
  EXPECT_THAT(html, HasSubstr("50.0 % of the frames in gaps"));
  EXPECT_THAT(html, HasSubstr("a &lt;test&gt;"));
  EXPECT_THAT(html, HasSubstr("jawOpen around its worst moment"));
  EXPECT_THAT(html, Not(HasSubstr("its offset taken")));
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(trackers_report(comparison, "take.mien", "", render::Image(8, 8))->html(),
              HasSubstr("the worst moment. Pale"));

  comparison.shared_clock = false;
  EXPECT_THAT(trackers_report(comparison, "take.mien", "")->html(),
              HasSubstr("vertex error, gaps held, all shapes, its offset taken out"));
  comparison.scores[0].offset_unknown = true;
  const std::string unknown = trackers_report(comparison, "take.mien", "")->html();
  EXPECT_THAT(unknown, HasSubstr("how much earlier or later it began than the truth was not found"));
  EXPECT_THAT(unknown, HasSubstr("its offset was not found; 50.0 %"));
  EXPECT_THAT(unknown, Not(HasSubstr("1.25 mm")));
}

}  // namespace
}  // namespace mien::lab::trackers_report_test
