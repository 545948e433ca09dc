#include "mien/session/prompt_script.h"
#include "tests/project_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace mien::session::prompt_script_test {
namespace {

using ::testing::HasSubstr;

TEST(PromptScript, IsReadWithBothSidesWhereNoneIsNamed) {
  const auto script = parse_prompts(R"(
name = "two"
seconds = 4
[[prompt]]
name = "rest"
seconds = 10
[[prompt]]
name = "smile"
say = "Smile"
weights = { mouthSmile = 1, browInnerUp_L = 0.25, jawOpen = 0.5 }
)",
                                    "here");
  ASSERT_TRUE(script) << script.error().message();
  EXPECT_EQ(script->name, "two");
  ASSERT_EQ(script->prompts.size(), 2u);
  EXPECT_EQ(script->prompts[0].target, face::BlendshapeWeights());
  EXPECT_EQ(script->prompts[0].seconds, 10);
  const Prompt& smile = script->prompts[1];
  EXPECT_EQ(smile.say, "Smile");
  EXPECT_EQ(smile.seconds, 4) << "the file's own";
  EXPECT_EQ(smile.target[face::shape("mouthSmile_L")], 1);
  EXPECT_EQ(smile.target[face::shape("mouthSmile_R")], 1);
  EXPECT_EQ(smile.target[face::shape("browInnerUp_L")], 0.25F);
  EXPECT_EQ(smile.target[face::shape("browInnerUp_R")], 0);
  EXPECT_EQ(smile.target[face::shape("jawOpen")], 0.5F);
  EXPECT_EQ(script->seconds(), 14);
}

TEST(PromptScript, LinesHaveTextsAndLabels) {
  const auto script = parse_prompts(R"(
language = "de"
[[prompt]]
name = "calm 1"
block = "calm"
emotion = "neutral"
text = "Größe übt leise."
own_pace = true
[[prompt]]
name = "calm 2"
block = "calm"
text = "Read on."
language = "en"
[[prompt]]
name = "smile"
block = "expressions"
weights = { mouthSmile = 1 }
)",
                                    "here");
  ASSERT_TRUE(script) << script.error().message();
  EXPECT_EQ(script->language, "de");
  ASSERT_EQ(script->prompts.size(), 3u);
  EXPECT_EQ(script->prompts[0].text, "Größe übt leise.");
  EXPECT_EQ(script->prompts[0].language, "de");
  EXPECT_EQ(script->prompts[0].emotion, "neutral");
  EXPECT_TRUE(script->prompts[0].own_pace);
  EXPECT_EQ(script->prompts[1].language, "en");
  EXPECT_FALSE(script->prompts[1].own_pace);
  EXPECT_EQ(script->prompts[2].language, "") << "nothing is read";
}

TEST(PromptScript, APoseLastsThreeSecondsUnlessItIsSaid) {
  const auto script = parse_prompts("[[prompt]]\nname = \"a\"\n", "here");
  ASSERT_TRUE(script);
  EXPECT_EQ(script->prompts[0].seconds, 3);
}

TEST(PromptScript, RefusesEachMistakeAloneAndSaysWhere) {
  const std::pair<const char*, const char*> mistakes[] = {
      {"", "asks for no pose"},
      {"name = \"a\"", "asks for no pose"},
      {"prompt = 3", "asks for no pose"},
      {"prompt = [1]", "is no table"},
      {"[[prompt]]\n", "name is empty"},
      {"[[prompt]]\nname = 3", "'name' is not text"},
      {"[[prompt]]\nname = \"a\"\nsay = 1", "'say' is not text"},
      {"[[prompt]]\nname = \"a\"\nseconds = \"3\"", "'seconds' is not a number"},
      {"[[prompt]]\nname = \"a\"\nseconds = true", "'seconds' is not a number"},
      {"[[prompt]]\nname = \"a\"\nown_pace = 1", "'own_pace' is neither"},
      {"[[prompt]]\nname = \"a\"\nblock = \"b\"\n[[prompt]]\nname = \"a\"\nblock = \"b\"",
       "'a' is there twice"},
      {"[[prompt]]\nname = \"a\"\nseconds = 0", "lasts 0 s"},
      {"[[prompt]]\nname = \"a\"\nseconds = nan", "lasts nan s"},
      {"seconds = -1\n[[prompt]]\nname = \"a\"", "lasts -1 s"},
      {"[[prompt]]\nname = \"a\"\nweights = 1", "'weights' is no table"},
      {"[[prompt]]\nname = \"a\"\nweights = { jawOpen = \"1\" }", "'jawOpen' is not a number"},
      {"[[prompt]]\nname = \"a\"\nweights = { jawOpen = 1.5 }", "'jawOpen' is 1.5"},
      {"[[prompt]]\nname = \"a\"\nweights = { jawOpen = nan }", "'jawOpen' is nan"},
      {"[[prompt]]\nname = \"a\"\nweights = { smirk = 1 }", "no shape 'smirk'"},
      {"[[prompt]]\nname = \"a\"\nweight = { jawOpen = 1 }", "unknown key 'weight'"},
      {"prompts = 1\n[[prompt]]\nname = \"a\"", "unknown key 'prompts'"},
      {"[[prompt]", "here"},
  };
  for (const auto& [text, said] : mistakes) {
    const auto script = parse_prompts(text, "here");
    ASSERT_FALSE(script) << text;
    EXPECT_TRUE(is_bad_input(script.error().code)) << text;
    EXPECT_THAT(script.error().message(), HasSubstr(said)) << text;
    EXPECT_THAT(script.error().message(), HasSubstr("here")) << text;
    EXPECT_EQ(script.error().message().find('\n'), std::string::npos) << text;
  }
  const auto line = parse_prompts("[[prompt]]\nname = \"a\"\nweights = { smirk = 1 }", "here");
  EXPECT_THAT(line.error().message(), HasSubstr("line 3"));
}

TEST(PromptScript, TooManyAreRefused) {
  std::string text;
  for (std::size_t i = 0; i < kMaxPrompts; ++i) text += "[[prompt]]\nname = \"a\"\n";
  EXPECT_TRUE(parse_prompts(text, "here"));
  EXPECT_EQ(parse_prompts(text + "[[prompt]]\nname = \"a\"\n", "here").error().code, ErrorCode::out_of_range);
}

TEST(PromptScript, TheShippedOneIsOneMinuteThatBeginsAtRestAndMovesBothSidesAlike) {
  const auto script = read_prompts(std::filesystem::path(project_path("prompts/one_minute.toml")));
  ASSERT_TRUE(script) << script.error().message();
  EXPECT_EQ(script->seconds(), 60);
  EXPECT_EQ(script->prompts.front().seconds, 10);
  EXPECT_EQ(script->prompts.front().target, face::BlendshapeWeights());
  for (const Prompt& prompt : script->prompts)
    for (std::size_t k = 0; k < face::kShapeCount; ++k) {
      const std::string_view name = face::kShapeNames[k];
      if (!name.ends_with("_L")) continue;
      const std::string other = std::string(name.substr(0, name.size() - 2)) + "_R";
      EXPECT_EQ(prompt.target[k], prompt.target[face::shape_index(other)]) << prompt.name << " " << name;
    }
}

}  // namespace
}  // namespace mien::session::prompt_script_test
