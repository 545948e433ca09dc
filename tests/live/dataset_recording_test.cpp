#include "mien/live/dataset_recording.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace mien::live::dataset_recording_test {
namespace {

using nlohmann::json;
using session::Prompting;

DatasetPlan plan(bool by_voice = false) {
  DatasetPlan out;
  out.wish = {"faces", "english", {"Anna", "a theatre", "to learn a face", true}, by_voice};
  out.take = "takes/faces/Anna_1.mien";
  out.prompts.resize(3);
  out.done = 4;
  return out;
}

Recorder::State running() {
  Recorder::State state;
  state.on = true;
  return state;
}

TEST(DatasetRecording, BeginsWithConsentThenAsksForWhatIsLeft) {
  DatasetRecording recording;
  EXPECT_FALSE(recording.state());
  auto commands = recording.begin(plan(true), "over", true);
  ASSERT_EQ(commands.size(), 5u);
  EXPECT_EQ(std::get<session::GiveConsent>(commands[0]).consent, plan().wish.consent);
  EXPECT_EQ(std::get<Prompting>(commands[1]).what, Prompting::Do::voice);
  EXPECT_TRUE(std::holds_alternative<session::AddPrompt>(commands[4]));
  ASSERT_TRUE(recording.state());
  EXPECT_EQ(recording.state()->take, "Anna_1.mien");
  EXPECT_EQ(recording.state()->lines, 3u);
  EXPECT_EQ(recording.state()->done, 4u);
  commands = recording.begin(plan(), "paused", true);
  ASSERT_EQ(commands.size(), 6u) << "what was asked for before ends first";
  EXPECT_EQ(std::get<Prompting>(commands[0]).what, Prompting::Do::stop);
  EXPECT_EQ(std::get<Prompting>(commands[2]).what, Prompting::Do::key);
}

TEST(DatasetRecording, NothingIsHeardOfWhoAgreedToNoSound) {
  DatasetRecording recording;
  DatasetPlan silent = plan();
  silent.wish.consent.sound = false;
  const auto commands = recording.begin(silent, "none", true);
  ASSERT_EQ(commands.size(), 6u);
  EXPECT_EQ(json::parse(std::get<session::Shape>(commands[0]).json),
            json::parse(R"({"merge": {"audio": false}})"));
  EXPECT_FALSE(std::get<session::GiveConsent>(commands[1]).consent.sound);
  recording.end();
  const auto over = recording.look(running(), "block").commands;
  ASSERT_EQ(over.size(), 3u);
  EXPECT_EQ(json::parse(std::get<session::Shape>(over[2]).json), json::parse(R"({"merge": {"audio": true}})"))
      << "the next one may have agreed";
  EXPECT_EQ(recording.begin(silent, "none", false).size(), 5u) << "who hears nothing need not be told";
  recording.end();
  EXPECT_EQ(recording.look(running(), "over").commands.size(), 2u)
      << "what it was about to ask for is stopped";
}

TEST(DatasetRecording, EndsTheTakeWhenEverythingWasAskedFor) {
  DatasetRecording recording;
  static_cast<void>(recording.begin(plan(), "over", true));
  EXPECT_FALSE(recording.look(running(), "over").end_recording) << "the session has not heard of it yet";
  EXPECT_FALSE(recording.look(running(), "block").end_recording);
  EXPECT_FALSE(recording.look(running(), "running").end_recording);
  const auto over = recording.look(running(), "over");
  EXPECT_TRUE(over.end_recording);
  ASSERT_EQ(over.commands.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<session::EndConsent>(over.commands[0]));
  EXPECT_TRUE(recording.state()->over);
  EXPECT_FALSE(recording.look(running(), "over").end_recording) << "once";
}

TEST(DatasetRecording, EndsWhenItsPerformerWantsNoMoreAndAsksForNothingFurther) {
  DatasetRecording recording;
  static_cast<void>(recording.begin(plan(), "none", true));
  static_cast<void>(recording.look(running(), "running"));
  recording.end();
  const auto next = recording.look(running(), "running");
  EXPECT_TRUE(next.end_recording);
  ASSERT_EQ(next.commands.size(), 2u);
  EXPECT_EQ(std::get<Prompting>(next.commands[0]).what, Prompting::Do::stop);
  EXPECT_TRUE(std::holds_alternative<session::EndConsent>(next.commands[1]));
  EXPECT_EQ(recording.state()->error, "");
}

TEST(DatasetRecording, ADiskThatIsFullEndsTheAskingToo) {
  DatasetRecording recording;
  static_cast<void>(recording.begin(plan(), "none", true));
  static_cast<void>(recording.look(running(), "running"));
  Recorder::State full;
  full.error = "the disk is full";
  const auto next = recording.look(full, "running");
  EXPECT_FALSE(next.end_recording);
  ASSERT_EQ(next.commands.size(), 2u);
  EXPECT_EQ(std::get<Prompting>(next.commands[0]).what, Prompting::Do::stop);
  EXPECT_TRUE(std::holds_alternative<session::EndConsent>(next.commands[1]));
  EXPECT_TRUE(recording.state()->over);
  EXPECT_EQ(recording.state()->error, "the disk is full");
}

TEST(DatasetRecording, APagesWishIsNotTakenWithoutThePerformersAgreement) {
  json begin = {{"name", "faces"},      {"script", "english"}, {"performer", "Anna"}, {"recorded_by", "us"},
                {"purpose", "a model"}, {"sound", true},       {"pace", "voice"}};
  EXPECT_FALSE(dataset_wish(begin));
  begin["agreed"] = "true";
  EXPECT_FALSE(dataset_wish(begin)) << "a text is no tick";
  begin["agreed"] = true;
  const auto wish = dataset_wish(begin);
  ASSERT_TRUE(wish) << wish.error().message();
  EXPECT_EQ(wish->dataset, "faces");
  EXPECT_EQ(wish->consent, (session::Consent{"Anna", "us", "a model", true}));
  EXPECT_TRUE(wish->by_voice);
  begin["video"] = 1;
  EXPECT_FALSE(dataset_wish(begin)->consent.video) << "a number is no tick either";
  begin["video"] = true;
  EXPECT_TRUE(dataset_wish(begin)->consent.video);
  EXPECT_FALSE(dataset_wish(json(3)));
}

TEST(DatasetRecording, APageIsToldOfScriptsBlocks) {
  DatasetShelf::Contents contents;
  contents.datasets = {{"faces", {{"Anna", {.takes = 2, .lines = 31}}}}};
  RecordingScript script{"english", {}};
  script.script.name = "English";
  script.script.language = "en";
  for (const char* block : {"calm", "calm", "emotional"}) {
    script.script.prompts.emplace_back().block = block;
    script.script.prompts.back().seconds = 4;
  }
  contents.scripts = {script};
  EXPECT_EQ(dataset_contents_json(contents), json::parse(R"({
    "datasets": [{"name": "faces", "performers": [{"name": "Anna", "takes": 2, "lines": 31}]}],
    "scripts": [{"name": "english", "title": "English", "language": "en", "blocks": [
      {"name": "calm", "lines": 2, "seconds": 8.0}, {"name": "emotional", "lines": 1, "seconds": 4.0}]}]})"));
}

}  // namespace
}  // namespace mien::live::dataset_recording_test
