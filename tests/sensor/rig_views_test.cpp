#include "mien/sensor/rig_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "mien/core/files.h"
#include "mien/sensor/rig.h"
#include "tests/folder.h"

namespace mien::sensor::rig_views_test {
namespace {

using testing::HasSubstr;

const char* const kRig = R"(# Whose headset this is.
name = "headset"
reference = "eye_L"

[[sensor]]
name = "eye_L"  # The left one.
kind = "camera"
site = "eye"
side = "L"
role = "face"
position_m = [0.05, 0.02, 0.1245]
[sensor.camera]
look_at_m = [0.031, 0.042, 0.093]
up = [0.0, 1.0, 0.0]
crop = [ 0.1,  # left
  0.2, 0.5, 0.5 ]  # Measured with a ruler.
mirror = false  # It looks from outside.

[[sensor]]
name = "eye_R"
kind = "camera"
site = "eye"
side = "R"
role = "face"
position_m = [-0.05, 0.02, 0.1245]
[sensor.camera] # Nothing is said of its view.
look_at_m = [-0.031, 0.042, 0.093]
up = [0.0, 1.0, 0.0]

[faults]
seat_mm = 2.0  # Of each donning.
)";

const PictureView kView{.crop = {0.25, 0, 0.5, 0.75}, .turn_deg = 90, .mirror = true};

PictureView view_in(const std::string& text, std::size_t sensor) {
  return view_of(*parse_rig(text, "test").value().sensors[sensor].camera);
}

TEST(RigViews, AreWrittenAndAllElseStaysAsItIs) {
  const auto both = with_views(kRig, std::vector<SensorView>{{"eye_L", kView}, {"eye_R", kView}}, "test");
  ASSERT_TRUE(both) << both.error().message();
  EXPECT_EQ(view_in(*both, 0), kView);
  EXPECT_EQ(view_in(*both, 1), kView);
  std::string expected = kRig;
  const auto replace = [&](const std::string& from, const std::string& to) {
    ASSERT_NE(expected.find(from), std::string::npos) << from;
    expected.replace(expected.find(from), from.size(), to);
  };
  replace("[ 0.1,  # left\n  0.2, 0.5, 0.5 ]", "[0.25, 0, 0.5, 0.75]");
  replace("mirror = false", "mirror = true");
  replace("[sensor.camera]\nlook_at_m = [0.031", "[sensor.camera]\nturn_deg = 90\nlook_at_m = [0.031");
  replace("of its view.\n", "of its view.\ncrop = [0.25, 0, 0.5, 0.75]\nturn_deg = 90\nmirror = true\n");
  EXPECT_EQ(*both, expected);
  // And back: what it says is said again, not left out.
  const auto back = with_views(*both, std::vector<SensorView>{{"eye_R", {}}}, "test");
  ASSERT_TRUE(back);
  EXPECT_EQ(view_in(*back, 1), PictureView());
  EXPECT_EQ(view_in(*back, 0), kView);
}

TEST(RigViews, AViewThatIsThereAlreadyChangesNoByte) {
  const PictureView there = view_in(kRig, 0);
  EXPECT_EQ(with_views(kRig, std::vector<SensorView>{{"eye_L", there}, {"eye_R", {}}}, "test").value(), kRig);
}

TEST(RigViews, DigitsComeBackAsTheyWere) {
  const PictureView odd{.crop = {0.1, 1.0 / 3, 0.7000000000000001, 0.05}, .turn_deg = 270, .mirror = false};
  const auto text = with_views(kRig, std::vector<SensorView>{{"eye_L", odd}}, "test");
  ASSERT_TRUE(text) << text.error().message();
  EXPECT_EQ(view_in(*text, 0), odd);
}

TEST(RigViews, RefuseEachMistakeAlone) {
  const auto refused = [](const std::string& rig, const std::string& sensor, const PictureView& view) {
    const auto text = with_views(rig, std::vector<SensorView>{{sensor, view}}, "test.toml");
    EXPECT_FALSE(text);
    return text ? Error() : text.error();
  };
  EXPECT_EQ(refused(kRig, "eye_M", kView).code, ErrorCode::not_found);
  EXPECT_EQ(refused("name = ", "eye_L", kView).code, ErrorCode::malformed);
  EXPECT_EQ(refused(kRig, "eye_L", {.crop = {0.5, 0, 0.6, 1}}).code, ErrorCode::internal) << "not read back";
  std::string in_braces = kRig;
  const std::size_t heading = in_braces.find("[sensor.camera] #");
  in_braces.replace(heading, in_braces.find("[faults]") - heading,
                    "camera = { look_at_m = [-0.031, 0.042, 0.093], up = [0.0, 1.0, 0.0] }\n");
  ASSERT_TRUE(parse_rig(in_braces, "test"));
  const Error error = refused(in_braces, "eye_R", kView);
  EXPECT_EQ(error.code, ErrorCode::unsupported);
  EXPECT_THAT(error.message(), HasSubstr("[sensor.camera]"));
}

TEST(RigViews, AFileIsReplacedOrLeftAsItIs) {
  const mien::test::Folder folder(mien::test::Folder::On::memory);
  const std::filesystem::path path = folder / "rig.toml";
  ASSERT_TRUE(write_file(path, std::string_view(kRig)));
  ASSERT_TRUE(write_views(path, std::vector<SensorView>{{"eye_L", kView}}));
  EXPECT_EQ(view_in(read_text(path).value(), 0), kView);
  const std::string now = read_text(path).value();
  EXPECT_FALSE(write_views(path, std::vector<SensorView>{{"eye_L", {}}, {"nobody", kView}}));
  EXPECT_EQ(read_text(path).value(), now);
  EXPECT_EQ(write_views(folder / "none.toml", std::vector<SensorView>{{"eye_L", kView}}).error().code,
            ErrorCode::not_found);
}

TEST(PictureView, AChangeKeepsWhatItDoesNotName) {
  const PictureView turned =
      changed_view(kView, {.crop = {}, .turn_deg = 180, .mirror = {}}, "eye_L").value();
  EXPECT_EQ(turned, (PictureView{.crop = kView.crop, .turn_deg = 180, .mirror = true}));
  EXPECT_EQ(changed_view(kView, {}, "eye_L").value(), kView);
}

TEST(PictureView, RefusesWhatIsNone) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const std::array<double, 4> crops[] = {{-0.01, 0, 1, 1},  {0, -0.01, 0.5, 0.5}, {0.5, 0, 0.51, 1},
                                         {0, 0.5, 1, 0.51}, {0, 0, 0.04, 1},      {0, 0, 1, 0.04},
                                         {kNone, 0, 1, 1},  {0, 0, 1, kNone},     {0, 0, 1e300, 1}};
  for (const auto& crop : crops) {
    const auto changed = changed_view({}, {.crop = crop, .turn_deg = {}, .mirror = {}}, "eye_L");
    ASSERT_FALSE(changed) << crop[0] << ' ' << crop[1] << ' ' << crop[2] << ' ' << crop[3];
    EXPECT_EQ(changed.error().code, ErrorCode::out_of_range);
  }
  for (const int turn : {-90, 1, 45, 360})
    EXPECT_FALSE(changed_view({}, {.crop = {}, .turn_deg = turn, .mirror = {}}, "eye_L")) << turn;
}

}  // namespace
}  // namespace mien::sensor::rig_views_test
