#include "mien/session/prompter.h"

#include "mien/take/take.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace mien::session::prompter_test {
namespace {

using State = Prompter::State;

Prompt pose(const std::string& name, double seconds) {
  Prompt prompt;
  prompt.name = name;
  prompt.seconds = seconds;
  prompt.target[face::shape("jawOpen")] = 0.5F;
  return prompt;
}

DeviceTime frame(double seconds) {
  return DeviceTime(frame_offset(static_cast<std::int64_t>(seconds * 60)));
}

/// Ticks from one time to before another; the events that came of it.
std::vector<take::Event> run(Prompter& prompter, double from_s, double to_s) {
  std::vector<take::Event> events;
  for (auto i = static_cast<std::int64_t>(from_s * 60); i < static_cast<std::int64_t>(to_s * 60); ++i)
    if (const auto shown = prompter.at(DeviceTime(frame_offset(i))))
      events.push_back({"prompt", shown->begin, shown->end, prompt_event_json(shown->prompt)});
  return events;
}

TEST(Prompter, AsksForOneAfterTheOtherAndWritesWhatWasShownToItsEnd) {
  Prompter prompter;
  EXPECT_EQ(prompter.place(frame(1)).state, State::none);
  ASSERT_TRUE(prompter.add(pose("open", 2)));
  ASSERT_TRUE(prompter.add(pose("again", 3)));
  EXPECT_EQ(prompter.place(frame(9)).state, State::ready) << "nothing begins before there are frames";
  EXPECT_EQ(prompter.place(frame(9)).remaining, Prompter::kLeadIn);

  const std::vector<take::Event> events = run(prompter, 10, 30);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].kind, "prompt");
  EXPECT_EQ(events[0].begin, frame(13));
  EXPECT_EQ(events[0].end, frame(15));
  EXPECT_EQ(events[0].json, R"({"name": "open", "target": {"jawOpen": 0.5}})");
  EXPECT_EQ(events[1].begin, frame(15)) << "without a gap";
  EXPECT_EQ(events[1].end, frame(18));
  EXPECT_EQ(prompter.place(frame(30)).state, State::over);
  EXPECT_EQ(prompter.place(frame(30)).prompt, nullptr);
}

TEST(Prompter, SaysWhereItIs) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(pose("one", 2)));
  ASSERT_TRUE(prompter.add(pose("two", 4)));
  run(prompter, 0, 4);
  const Prompter::Place place = prompter.place(frame(4));
  EXPECT_EQ(place.state, State::running);
  EXPECT_EQ(place.prompt->name, "one");
  EXPECT_EQ(place.next->name, "two");
  EXPECT_EQ(place.number, 1u);
  EXPECT_EQ(place.of, 2u);
  EXPECT_NEAR(place.progress, 0.5, 1e-9);
  EXPECT_NEAR(to_seconds(place.remaining), 1, 1e-6);
  EXPECT_NEAR(to_seconds(place.left), 5, 1e-6);
  EXPECT_EQ(prompter.place(frame(1)).state, State::ready);
  EXPECT_NEAR(to_seconds(prompter.place(frame(1)).left), 2 + 6, 1e-6);
  run(prompter, 4, 6);
  EXPECT_EQ(prompter.place(frame(6)).next, nullptr) << "the last one";
}

TEST(Prompter, ASkippedOneLeavesNoEventAndTheNextBeginsAtOnce) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(pose("one", 2)));
  ASSERT_TRUE(prompter.add(pose("two", 2)));
  EXPECT_TRUE(run(prompter, 0, 4).empty());
  ASSERT_TRUE(prompter.skip());
  const auto events = run(prompter, 4, 20);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].begin, frame(4));
  EXPECT_FALSE(prompter.skip()) << "all are over";
}

TEST(Prompter, APauseInterruptsOneThatIsThenShownWhole) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(pose("one", 2)));
  run(prompter, 0, 4);
  ASSERT_TRUE(prompter.pause(true));
  ASSERT_TRUE(prompter.pause(true)) << "the same again changes nothing";
  EXPECT_TRUE(run(prompter, 4, 60).empty());
  EXPECT_EQ(prompter.place(frame(60)).state, State::paused);
  ASSERT_TRUE(prompter.pause(false));
  const auto events = run(prompter, 60, 80);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].begin, frame(63)) << "with time to get ready";
}

TEST(Prompter, GetsReadyAgainForWhatIsAddedAfterTheLastOneRanOut) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(pose("one", 2)));
  EXPECT_EQ(run(prompter, 0, 20).size(), 1u);
  EXPECT_EQ(prompter.place(frame(20)).state, State::over);
  ASSERT_TRUE(prompter.add(pose("two", 2)));
  const auto events = run(prompter, 20, 40);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].begin, frame(23)) << "not a moment before it was shown";
}

TEST(Prompter, EndsWhenToldToAndGetsReadyAgainForWhatIsAddedLater) {
  Prompter prompter;
  EXPECT_FALSE(prompter.stop());
  EXPECT_FALSE(prompter.pause(true));
  ASSERT_TRUE(prompter.add(pose("one", 2)));
  run(prompter, 0, 4);
  ASSERT_TRUE(prompter.stop());
  EXPECT_TRUE(run(prompter, 4, 20).empty());
  EXPECT_EQ(prompter.place(frame(20)).state, State::over);
  ASSERT_TRUE(prompter.add(pose("two", 2)));
  const auto events = run(prompter, 20, 40);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].begin, frame(23));
}

TEST(Prompter, WhereFramesAreMissingThePoseWaits) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(pose("one", 2)));
  ASSERT_TRUE(prompter.add(pose("two", 2)));
  run(prompter, 0, 4);
  auto late = prompter.at(frame(100));
  ASSERT_TRUE(late);
  EXPECT_EQ(late->end, frame(5));
  const auto events = run(prompter, 101, 110);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].begin, frame(101)) << "nobody saw it before";
}

Prompt line(const std::string& name, const std::string& block) {
  Prompt prompt;
  prompt.name = name;
  prompt.text = "Grüß Gott";
  prompt.block = block;
  prompt.seconds = 4;
  prompt.own_pace = true;
  return prompt;
}

TEST(Prompter, ABlockWaitsUntilItIsBegunAndALineUntilThePerformerGoesOn) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(line("one", "calm")));
  ASSERT_TRUE(prompter.add(line("two", "calm")));
  ASSERT_TRUE(prompter.add(line("three", "emotional")));
  EXPECT_TRUE(run(prompter, 0, 60).empty());
  EXPECT_EQ(prompter.place(frame(60)).state, State::block);
  EXPECT_FALSE(prompter.go_on()) << "nothing is shown";
  ASSERT_TRUE(prompter.begin_block());
  EXPECT_FALSE(prompter.begin_block()) << "it is begun";
  run(prompter, 60, 62);
  EXPECT_EQ(prompter.place(frame(62)).state, State::ready);
  EXPECT_TRUE(run(prompter, 62, 90).empty()) << "longer than usual, and nobody went on";
  ASSERT_TRUE(prompter.go_on());
  auto events = run(prompter, 90, 95);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].begin, frame(63));
  EXPECT_EQ(events[0].end, frame(90));
  EXPECT_EQ(events[0].json, "{\"name\": \"one\", \"text\": \"Grüß Gott\", \"block\": \"calm\"}");
  EXPECT_EQ(prompter.place(frame(95)).state, State::running) << "the next one at once";
  ASSERT_TRUE(prompter.go_on());
  EXPECT_EQ(run(prompter, 95, 120).size(), 1u);
  EXPECT_EQ(prompter.place(frame(120)).state, State::block) << "another block";
  EXPECT_EQ(prompter.place(frame(120)).number, 3u);
}

TEST(Prompter, ALineIsReadAgainFromItsBeginningOrTheOneBeforeIt) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(line("one", "calm")));
  ASSERT_TRUE(prompter.add(line("two", "calm")));
  run(prompter, 0, 1);
  ASSERT_TRUE(prompter.begin_block());
  run(prompter, 1, 8);
  ASSERT_TRUE(prompter.repeat());
  run(prompter, 8, 12);
  ASSERT_TRUE(prompter.go_on());
  auto events = run(prompter, 12, 12.5);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].begin, frame(9)) << "anew, after a second";
  ASSERT_TRUE(prompter.repeat()) << "the second has hardly begun";
  run(prompter, 12.5, 16);
  EXPECT_EQ(prompter.place(frame(16)).prompt->name, "one");
  ASSERT_TRUE(prompter.repeat());
  ASSERT_TRUE(prompter.repeat());
  run(prompter, 16, 18);
  EXPECT_EQ(prompter.place(frame(18)).prompt->name, "one") << "nothing is before it";
}

TEST(Prompter, ALineIsOverWhenItWasSpokenWhereTheVoiceIsFollowed) {
  for (const bool follow : {true, false}) {
    Prompter prompter;
    prompter.follow_voice(follow);
    ASSERT_TRUE(prompter.add(line("one", "calm")));
    run(prompter, 0, 1);
    ASSERT_TRUE(prompter.begin_block());
    std::optional<Prompter::Shown> shown;
    for (int i = 60; i < 60 * 12 && !shown; ++i) {
      // Silence, a word, a breath, the rest of it, silence.
      const double s = i / 60.0;
      shown = prompter.at(DeviceTime(frame_offset(i)), (s > 6 && s < 6.3) || (s > 7 && s < 9));
    }
    ASSERT_EQ(shown.has_value(), follow);
    if (follow) {
      EXPECT_NEAR(to_seconds(shown->end - frame(0)), 9 + 1.2, 0.05);
    }
  }
}

TEST(Prompter, WhatWasPoorIsAskedForAgainAtTheEndTwiceAtMostAndNotWhenItWasGoodAfterAll) {
  Prompter prompter;
  Prompt first = line("one", "calm");
  first.own_pace = false;
  Prompt second = first;
  second.name = "two";
  ASSERT_TRUE(prompter.add(first));
  ASSERT_TRUE(prompter.add(second));
  run(prompter, 0, 1);
  ASSERT_TRUE(prompter.begin_block());
  ASSERT_EQ(run(prompter, 1, 8.5).size(), 1u);
  EXPECT_TRUE(prompter.ask_again(first));
  EXPECT_EQ(prompter.place(frame(9)).again, 1u);
  ASSERT_EQ(run(prompter, 8.5, 30).size(), 1u);
  EXPECT_EQ(prompter.place(frame(30)).state, State::block) << "once more";
  EXPECT_EQ(prompter.place(frame(30)).prompt->attempt, 2);
  Prompt third = first;
  third.attempt = 2;
  EXPECT_FALSE(prompter.ask_again(third)) << "it is still to come";
  ASSERT_TRUE(prompter.begin_block());
  ASSERT_EQ(run(prompter, 30, 40).size(), 1u);
  EXPECT_TRUE(prompter.ask_again(third));
  EXPECT_EQ(prompter.place(frame(40)).of, 4u);
  prompter.accept(first);
  EXPECT_EQ(prompter.place(frame(40)).state, State::over);
  EXPECT_FALSE(prompter.ask_again(first)) << "it was good once";
  third.attempt = kMaxAttempts;
  EXPECT_FALSE(prompter.ask_again(third));
}

TEST(Prompter, WhereNobodyGoesOnItPausesBeforeTheTakeIsFullOfNothing) {
  Prompter prompter;
  ASSERT_TRUE(prompter.add(line("one", "calm")));
  run(prompter, 0, 1);
  ASSERT_TRUE(prompter.begin_block());
  EXPECT_TRUE(run(prompter, 1, 700).empty());
  EXPECT_EQ(prompter.place(frame(700)).state, State::paused);
}

TEST(Prompter, RefusesEachMistakeAlone) {
  Prompter prompter;
  const auto refused = [&](auto change) {
    Prompt prompt = pose("a", 3);
    change(prompt);
    const auto done = prompter.add(prompt);
    return !done && done.error().code == ErrorCode::out_of_range;
  };
  EXPECT_TRUE(refused([](Prompt& p) { p.name.clear(); }));
  EXPECT_TRUE(refused([](Prompt& p) { p.name = std::string(61, 'a'); }));
  EXPECT_TRUE(refused([](Prompt& p) { p.name = "a\x1b[2J"; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.say = std::string(201, 'a'); }));
  EXPECT_TRUE(refused([](Prompt& p) { p.say = "\n"; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.text = std::string(2001, 'a'); }));
  EXPECT_TRUE(refused([](Prompt& p) { p.text = "\xff is no UTF-8"; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.text = "two\nlines"; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.block = std::string(41, 'a'); }));
  EXPECT_TRUE(refused([](Prompt& p) { p.emotion = "\x1b"; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.language = std::string(36, 'a'); }));
  EXPECT_TRUE(refused([](Prompt& p) { p.attempt = 0; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.seconds = 0.4; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.seconds = 601; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.seconds = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(refused([](Prompt& p) { p.target[3] = -0.1F; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.target[3] = 1.1F; }));
  EXPECT_TRUE(refused([](Prompt& p) { p.target[3] = std::numeric_limits<float>::infinity(); }));
  for (std::size_t i = 0; i < kMaxPrompts; ++i) ASSERT_TRUE(prompter.add(pose("a", 1)));
  EXPECT_TRUE(refused([](Prompt&) {}));
}

}  // namespace
}  // namespace mien::session::prompter_test
