#include "mien/face/compiler/profile_toml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/files.h"
#include "tests/project_path.h"

namespace mien::face::profile_toml_test {
namespace {

using ::testing::HasSubstr;

std::string text_of(const std::string& profile) {
  auto text = read_text(project_path("profiles/" + profile + ".toml"), std::size_t{1} << 20U);
  EXPECT_TRUE(text) << text.error().message();
  return text ? *std::move(text) : std::string();
}

/// The text with one line changed; the number of that line stands in `line`.
std::string with(std::string text, std::string_view old_line, std::string_view new_line, std::size_t& line) {
  const std::size_t at = text.find("\n" + std::string(old_line) + "\n");
  EXPECT_NE(at, std::string::npos) << old_line;
  line = static_cast<std::size_t>(
             std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n')) +
         2;
  return text.replace(at + 1, old_line.size(), new_line);
}

const ProfileRow& row(const ProfileTable& table, std::string_view shape) {
  const auto found = std::ranges::find(table.names->shapes, shape);
  return table.rows[static_cast<std::size_t>(found - table.names->shapes.begin())];
}

TEST(ProfileToml, ReadsGainsSharesAndReasons) {
  std::size_t line = 0;
  std::string text = with(text_of("unified"), "BrowLowererRight = { browDown_R = 1 }",
                          "BrowLowererRight = { browDown_R = 2, browDown_L = 0.5 }", line);
  text = with(text, "BrowLowererRight = 0.75", "BrowLowererRight = 0.25", line);
  text = with(text, "BrowPinchRight = 0.25", "BrowPinchRight = 0.75", line);
  // browDown_L is told by three then: a quarter each way but for the pinching.
  text = with(text, "BrowLowererLeft = 0.75", "BrowLowererLeft = 0.5", line);
  const auto table = parse_profile(text, "t.toml");
  ASSERT_TRUE(table) << table.error().message();
  const ProfileRow& lowerer = row(*table, "BrowLowererRight");
  ASSERT_EQ(lowerer.gains.size(), 2U);
  EXPECT_EQ(lowerer.gains[0].column, shape("browDown_L"));
  EXPECT_EQ(lowerer.gains[0].factor, 0.5F);
  EXPECT_EQ(lowerer.gains[1].factor, 2.0F);
  EXPECT_EQ(lowerer.share, 0.25);
  EXPECT_FALSE(row(*table, "JawOpen").share);
  EXPECT_THAT(row(*table, "JawClench").reason, HasSubstr("teeth"));
  EXPECT_THAT(table->lacks[shape("eyeBlink_R")], HasSubstr("v2/EyeOpen"));

  // Out: the mean of both gains. In: share over gain.
  const SparseRowsData out = outward_rows(*table);
  const std::size_t lowerer_at = 6;
  ASSERT_EQ(table->names->shapes[lowerer_at], "BrowLowererRight");
  const std::size_t first = out.first[lowerer_at];
  ASSERT_EQ(out.first[lowerer_at + 1] - first, 2U);
  EXPECT_EQ(out.terms[first].factor, 0.25F);
  EXPECT_EQ(out.terms[first + 1].factor, 1.0F);
  const SparseRowsData in = inward_rows(*table);
  const std::size_t brow = in.first[shape("browDown_R")];
  EXPECT_EQ(in.terms[brow].factor, 0.75F);       // Of the pinching.
  EXPECT_EQ(in.terms[brow + 1].factor, 0.125F);  // 0.25 / 2.
  ASSERT_EQ(out.first.size(), 89U);
  ASSERT_EQ(in.first.size(), kInnerCount + 1);
}

/// One line changed: what is said, and whether it names that line.
struct Wrong {
  std::string profile;
  std::string old_line;
  std::string new_line;
  std::string says;
  bool names_the_line = true;
};

TEST(ProfileToml, WhatIsWrongIsRefusedInOneLineThatNamesItsPlace) {
  const std::vector<Wrong> cases = {
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DRIP = { jawOpen = 1 }", "did you mean JAW_DROP?"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpne = 1 }", "did you mean jawOpen?"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_THRUST = { jawOpen = 1 }", "JAW_THRUST", false},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen = nan }", "is nan"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen = inf }", "is inf"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen = 1e39 }", "is 1e+39"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen = 0 }", "is 0"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen = -1 }", "is -1"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen = \"1\" }", "is not a number"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen = true }", "is not a number"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = \"jawOpen\"", "'JAW_DROP' has no gain"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = {}", "'JAW_DROP' has no gain"},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawOpen }", ""},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "", "'JAW_DROP' is missing", false},
      {"openxr_fb_63", "JAW_DROP = { jawOpen = 1 }", "JAW_DROP = { jawForward = 1 }", "inner shape 'jawOpen'",
       false},
      {"openxr_fb_63", "CHEEK_SUCK_L = \"no inner shape draws the cheeks in; cheekPuff only blows them out\"",
       "JAW_DROP = \"why\"", "'JAW_DROP' is told of twice"},
      {"openxr_fb_63", "CHEEK_SUCK_L = \"no inner shape draws the cheeks in; cheekPuff only blows them out\"",
       "CHEEK_SUCK_L = \"\"", "'CHEEK_SUCK_L' is no text"},
      {"openxr_fb_63", "tongueOut = \"the tongue came with XR_FB_face_tracking2 (openxr_fb_70)\"",
       "jawOpen = \"why\"", "'jawOpen' is told of twice"},
      {"openxr_fb_63", "tongueOut = \"the tongue came with XR_FB_face_tracking2 (openxr_fb_70)\"",
       "tongueUot = \"why\"", "did you mean tongueOut?"},
      {"openxr_fb_63", "name = \"openxr_fb_63\"", "name = \"openxr_fb_36\"", "did you mean openxr_fb_63?"},
      {"openxr_fb_63", "name = \"openxr_fb_63\"", "nane = \"openxr_fb_63\"", "unknown key 'nane'"},
      {"openxr_fb_63", "title = \"OpenXR XR_FB_face_tracking\"", "", "'title' is missing", false},
      {"openxr_fb_70", "extends = \"openxr_fb_63\"", "extends = \"openxr_fb_36\"",
       "no profile 'openxr_fb_36'"},
      {"openxr_fb_70", "TONGUE_OUT = { tongueOut = 1 }", "JAW_DROP = { tongueOut = 1 }", "told of twice"},
      {"unified", "BrowPinchRight = 0.25", "BrowPinchRight = 1.25", "shares go from 0 to 1"},
      {"unified", "BrowPinchRight = 0.25", "BrowPinchRight = nan", "is nan"},
      {"unified", "BrowPinchRight = 0.25", "JawClench = 0.25", "a share but no gain"},
      {"unified", "BrowPinchRight = 0.25", "BrowPinchRight = 0.5", "'browDown_R' sum to 1.25", false},
      {"unified", "BrowPinchRight = 0.25", "", "1 of 2 shapes", false},
  };
  const auto first = parse_profile(text_of("openxr_fb_63"), "63");
  ASSERT_TRUE(first) << first.error().message();
  const std::vector<ProfileTable> earlier = {*first};
  for (const Wrong& wrong : cases) {
    SCOPED_TRACE(wrong.new_line);
    std::size_t line = 0;
    const std::string text = with(text_of(wrong.profile), wrong.old_line, wrong.new_line, line);
    const auto refused = parse_profile(text, "t.toml", earlier);
    ASSERT_FALSE(refused);
    const std::string message = refused.error().message();
    EXPECT_THAT(message, HasSubstr(wrong.says));
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_THAT(message, HasSubstr(wrong.names_the_line ? "t.toml, line " + std::to_string(line) + ":"
                                                        : std::string("t.toml")));
  }
}

TEST(ProfileToml, RefusesTablesThatAreNone) {
  for (const char* text : {"", "name = 3", "name = \"unified\"\ntitle = \"t\"\nsource = \"s\"\nmap = 3",
                           "name = \"unified\"\ntitle = \"t\"\nsource = \"s\"\nlacks = []", "name = ["})
    EXPECT_FALSE(parse_profile(text, "t.toml")) << text;
}

}  // namespace
}  // namespace mien::face::profile_toml_test
