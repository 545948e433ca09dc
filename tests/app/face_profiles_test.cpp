// `mien face profiles`, as a script and as a reader see it.
#include <gmock/gmock.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/app/program.h"

namespace mien::app::test::face_profiles_test {
namespace {

using ::testing::HasSubstr;

nlohmann::json json_of(const std::vector<std::string>& arguments) {
  const Outcome done = run(arguments);
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(done.err, "");
  auto json = nlohmann::json::parse(done.out, nullptr, false);
  EXPECT_TRUE(json.is_object()) << done.out;
  return json;
}

TEST(FaceProfiles, SayEachReasonInJson) {
  const auto all = json_of({"face", "profiles", "--json"})["profiles"];
  std::map<std::string, nlohmann::json> by_name;
  for (const auto& profile : all) by_name[profile["name"]] = profile;
  ASSERT_EQ(by_name.size(), 5U);

  const auto& fb = by_name.at("openxr_fb_70");
  EXPECT_EQ(fb["shapes"], 70);
  EXPECT_EQ(fb["matched"], 60);
  EXPECT_EQ(fb["inner_told"], 54);
  EXPECT_EQ(fb["divided"], 4);
  EXPECT_TRUE(fb["groups"].empty());
  EXPECT_TRUE(fb["inner_lacking"].empty());
  ASSERT_EQ(fb["without_counterpart"].size(), 10U);
  EXPECT_EQ(fb["without_counterpart"][0]["shape"], "CHEEK_SUCK_L");
  EXPECT_THAT(fb["without_counterpart"][0]["reason"], HasSubstr("cheeks"));

  const auto& refa = by_name.at("refa_64");
  ASSERT_EQ(refa["groups"].size(), 7U);
  EXPECT_EQ(refa["groups"][4], (nlohmann::json{{"name", "upper lip"}, {"shapes", 11}}));
  EXPECT_THAT(refa["source"], HasSubstr("ours"));
  EXPECT_EQ(by_name.at("arkit52")["merged"], 2);
  EXPECT_EQ(by_name.at("unified")["inner_lacking"].size(), 10U);
}

TEST(FaceProfiles, OneIsShownShapeByShape) {
  const auto unified = json_of({"face", "profiles", "unified", "--json"});
  const auto& table = unified["table"];
  ASSERT_EQ(table.size(), 88U);
  EXPECT_EQ(table[4]["shape"], "BrowPinchRight");
  EXPECT_EQ(table[4]["inner"],
            (nlohmann::json::array({{{"shape", "browDown_R"}, {"factor", 1.0}, {"factor_back", 0.25}}})));
  EXPECT_EQ(table[27]["shape"], "JawClench");
  EXPECT_TRUE(table[27]["inner"].empty());
  EXPECT_THAT(table[27]["reason"], HasSubstr("teeth"));
  EXPECT_FALSE(table[4].contains("reason"));
  EXPECT_FALSE(table[4].contains("group"));
  EXPECT_EQ(json_of({"face", "profiles", "refa_64", "--json"})["table"][0]["group"], "brow");

  const Outcome shown = run({"face", "profiles", "arkit52"});
  EXPECT_EQ(shown.status, 0);
  EXPECT_THAT(shown.out, ::testing::ContainsRegex("cheekPuff +cheekPuff_L +0.5 +1\n +cheekPuff_R +0.5 +1\n"));
  const Outcome listed = run({"face", "profiles"});
  EXPECT_THAT(listed.out, HasSubstr("LIP_TIGHTENER_L, LIP_TIGHTENER_R: no inner shape narrows"));
}

}  // namespace
}  // namespace mien::app::test::face_profiles_test
