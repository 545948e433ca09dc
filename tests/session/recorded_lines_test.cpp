#include "mien/session/recorded_lines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mien/session/prompt.h"

namespace mien::session::recorded_lines_test {
namespace {

using ::testing::ElementsAre;

DeviceTime at(int seconds) {
  return DeviceTime(std::chrono::seconds(seconds));
}

take::Event prompt(int from, const std::string& json) {
  return {"prompt", at(from), at(from + 2), json};
}

const Consent kAnna{"Anna", "a theatre", "to learn a face", true};

TEST(RecordedLines, WhatWasBeforeTheLastConsentIsNobodys) {
  const std::vector<take::Event> events = {
      {"consent", at(1), at(1), consent_event_json({"Bert", "a theatre", "to learn a face", false})},
      prompt(2, R"({"name": "one", "block": "calm"})"),
      {"consent", at(5), at(5), consent_event_json(kAnna)},
      {"neutral", at(6), at(9), ""},
      prompt(9, R"({"name": "two", "text": "Lies.", "block": "calm", "emotion": "joy", "language": "de"})"),
      prompt(
          12,
          R"({"name": "three", "block": "calm", "target": {"jawOpen": 0.5, "nose": 3}, "attempt": 2, "poor": ["a", 3]})"),
      prompt(15, "no JSON"),
      prompt(16, R"({"name": "smile", "target": {"jawOpen": 1}})"),
      {"consent", at(20), at(20), R"({"performer": ""})"},
  };
  const auto part = recorded_part(events);
  ASSERT_TRUE(part);
  EXPECT_EQ(part->consent, kAnna);
  EXPECT_EQ(part->begin, at(5));
  ASSERT_EQ(part->lines.size(), 2u);
  EXPECT_EQ(part->lines[0].name, "two");
  EXPECT_EQ(part->lines[0].text, "Lies.");
  EXPECT_EQ(part->lines[0].emotion, "joy");
  EXPECT_EQ(part->lines[0].language, "de");
  EXPECT_EQ(part->lines[0].begin, at(9));
  EXPECT_EQ(part->lines[0].end, at(11));
  EXPECT_FALSE(part->lines[0].has_target);
  EXPECT_TRUE(part->lines[1].has_target);
  EXPECT_EQ(part->lines[1].target[face::shape("jawOpen")], 0.5F);
  EXPECT_EQ(part->lines[1].attempt, 2);
  EXPECT_THAT(part->lines[1].poor, ElementsAre("a"));
}

TEST(RecordedLines, WhatComesWhenTheConsentIsOverIsNobodysEither) {
  const std::string line = R"({"name": "one", "block": "calm"})";
  std::vector<take::Event> events = {{"consent", at(1), at(1), consent_event_json(kAnna)},
                                     prompt(2, line),
                                     {"consent_over", at(5), at(5), ""},
                                     prompt(6, line)};
  auto part = recorded_part(events);
  ASSERT_TRUE(part);
  EXPECT_EQ(part->end, at(5));
  EXPECT_EQ(part->lines.size(), 1u);
  events.push_back({"consent", at(8), at(8), consent_event_json(kAnna)});
  events.push_back(prompt(9, line));
  part = recorded_part(events);
  ASSERT_TRUE(part);
  EXPECT_FALSE(part->end) << "that of before is over, this one is not";
  EXPECT_EQ(part->begin, at(8));
}

TEST(RecordedLines, WithoutConsentThereAreNone) {
  EXPECT_FALSE(recorded_part({}));
  const std::vector<take::Event> events = {prompt(2, R"({"name": "one"})"), {"consent", at(1), at(1), "{}"}};
  EXPECT_FALSE(recorded_part(events));
}

TEST(RecordedLines, OfSeveralAttemptsTheLastGoodOneCounts) {
  RecordedPart part;
  const auto add = [&part](const std::string& name, bool good) {
    RecordedLine line;
    line.name = name;
    line.attempt = static_cast<int>(part.lines.size());
    if (!good) line.poor = {"chin was lost"};
    part.lines.push_back(line);
  };
  add("good twice", true);
  add("poor then good", false);
  add("good then poor", true);
  add("poor twice", false);
  add("good twice", true);
  add("poor then good", true);
  add("good then poor", false);
  add("poor twice", false);
  std::vector<int> attempts;
  for (const RecordedLine* line : lines_that_count(part)) attempts.push_back(line->attempt);
  EXPECT_THAT(attempts, ElementsAre(4, 5, 2, 7));
}

TEST(RecordedLines, APromptsEventIsReadAsItWasWritten) {
  Prompt said;
  said.name = "a \"line\"";
  said.text = "¿Qué tal?";
  said.block = "emotional";
  said.emotion = "joy";
  said.language = "es";
  said.attempt = 3;
  const std::vector<std::string> poor = {"phone saw no face"};
  const std::vector<take::Event> events = {{"consent", at(0), at(0), consent_event_json(kAnna)},
                                           prompt(1, prompt_event_json(said, poor))};
  const auto part = recorded_part(events);
  ASSERT_TRUE(part);
  ASSERT_EQ(part->lines.size(), 1u);
  EXPECT_EQ(part->lines[0].name, said.name);
  EXPECT_EQ(part->lines[0].text, said.text);
  EXPECT_EQ(part->lines[0].block, said.block);
  EXPECT_EQ(part->lines[0].emotion, said.emotion);
  EXPECT_EQ(part->lines[0].language, said.language);
  EXPECT_EQ(part->lines[0].attempt, 3);
  EXPECT_EQ(part->lines[0].poor, poor);
}

}  // namespace
}  // namespace mien::session::recorded_lines_test
