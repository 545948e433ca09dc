#include "mien/live/phone_lesson.h"

#include <gtest/gtest.h>

#include <future>

namespace mien::live::phone_lesson_test {
namespace {

using session::Prompting;
using Stage = PhoneLesson::Stage;

Recorder::State recording(bool on, const std::string& error = {}) {
  Recorder::State state;
  state.on = on;
  state.error = error;
  return state;
}

/// A lesson of two prompts, and what its learning gave.
struct Class {
  std::promise<Result<TaughtByPhone>> learnt;
  std::filesystem::path taken;
  bool teaches = true;
  PhoneLesson lesson{
      {.script =
           [] {
             session::PromptScript script;
             script.prompts.resize(2);
             return Result<session::PromptScript>(script);
           },
       .learn = [this](const std::filesystem::path& take, const Progress& progress) -> Result<TaughtByPhone> {
         taken = take;
         if (!progress(0.5, "learning")) return fail(ErrorCode::cancelled, "stopped", "take");
         if (!teaches) return fail(ErrorCode::mismatch, "somebody else's phone", "take");
         return TaughtByPhone{{.network = "", .weights = {1}, .bias = {}}, "better"};
       }},
      [this](Result<TaughtByPhone> result) { learnt.set_value(std::move(result)); }};
};

TEST(PhoneLesson, WhatWasRecordedIsLearntAndComesIntoForceByACommand) {
  Class one;
  EXPECT_TRUE(one.lesson.can());
  const auto asked = one.lesson.begin("phone.mien", "over", 3);
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->size(), 2u);
  EXPECT_FALSE(one.lesson.begin("other.mien", "over", 3)) << "one at a time";
  static_cast<void>(one.lesson.look(recording(false), "over"));
  EXPECT_EQ(one.lesson.state().stage, Stage::recording) << "its file is still being made";
  one.lesson.recording_begun();
  EXPECT_FALSE(one.lesson.look(recording(true), "over").end_recording)
      << "the session has not heard of it yet";
  EXPECT_FALSE(one.lesson.look(recording(true), "running").end_recording);
  EXPECT_TRUE(one.lesson.look(recording(true), "over").end_recording);
  EXPECT_FALSE(one.lesson.look(recording(true), "over").end_recording) << "once";
  EXPECT_EQ(one.lesson.state().stage, Stage::recording) << "the take is still being written";
  static_cast<void>(one.lesson.look(recording(false), "over"));
  EXPECT_EQ(one.lesson.state().stage, Stage::learning);
  const Result<TaughtByPhone> learnt = one.learnt.get_future().get();
  EXPECT_EQ(one.lesson.state().learnt, 0.5);
  const auto commands = one.lesson.finish(learnt, 3);
  EXPECT_EQ(one.taken, "phone.mien");
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_EQ(std::get<session::Correct>(commands[0]).correction.weights, std::vector<float>{1});
  EXPECT_FALSE(one.lesson.in_force(false));
  EXPECT_EQ(one.lesson.state().stage, Stage::learning) << "the session has not obeyed yet";
  EXPECT_TRUE(one.lesson.in_force(true));
  EXPECT_FALSE(one.lesson.in_force(true)) << "once";
  EXPECT_EQ(one.lesson.state().stage, Stage::done);
  EXPECT_EQ(one.lesson.state().sentence, "better");
  one.lesson.refuse("another command");
  EXPECT_EQ(one.lesson.state().stage, Stage::done);
}

/// A lesson whose learning is over.
void learn(Class& one) {
  ASSERT_TRUE(one.lesson.begin("phone.mien", "over", 3));
  one.lesson.recording_begun();
  static_cast<void>(one.lesson.look(recording(true), "running"));
  static_cast<void>(one.lesson.look(recording(true), "over"));
  static_cast<void>(one.lesson.look(recording(false), "over"));
  ASSERT_EQ(one.lesson.state().stage, Stage::learning);
}

TEST(PhoneLesson, WhatTheSessionRefusesOrBelongsToAnotherCalibrationIsNotSaidToBeInForce) {
  Class refused, moved, cancelled;
  learn(refused);
  EXPECT_EQ(refused.lesson.finish(refused.learnt.get_future().get(), 3).size(), 1u);
  refused.lesson.refuse("nothing is calibrated yet");
  EXPECT_EQ(refused.lesson.state().stage, Stage::failed);
  EXPECT_FALSE(refused.lesson.in_force(true));
  learn(moved);
  EXPECT_TRUE(moved.lesson.finish(moved.learnt.get_future().get(), 4).empty());
  EXPECT_EQ(moved.lesson.state().stage, Stage::failed);
  learn(cancelled);
  cancelled.lesson.cancel();
  EXPECT_TRUE(cancelled.lesson.finish(cancelled.learnt.get_future().get(), 3).empty());
  EXPECT_EQ(cancelled.lesson.state().stage, Stage::failed);
}

TEST(PhoneLesson, WhatIsThrownWhileLearningEndsTheLessonAlone) {
  std::promise<Result<TaughtByPhone>> learnt;
  PhoneLesson lesson({.script =
                          [] {
                            return Result<session::PromptScript>(session::PromptScript{{}, {}, {{}}});
                          },
                      .learn = [](const std::filesystem::path&, const Progress&) -> Result<TaughtByPhone> {
                        throw std::bad_alloc();
                      }},
                     [&learnt](Result<TaughtByPhone> result) { learnt.set_value(std::move(result)); });
  ASSERT_TRUE(lesson.begin("phone.mien", "over", 3));
  lesson.recording_begun();
  static_cast<void>(lesson.look(recording(true), "running"));
  static_cast<void>(lesson.look(recording(true), "over"));
  static_cast<void>(lesson.look(recording(false), "over"));
  EXPECT_FALSE(learnt.get_future().get());
}

TEST(PhoneLesson, WhatCannotBeLearntChangesNothing) {
  Class one;
  one.teaches = false;
  ASSERT_TRUE(one.lesson.begin("phone.mien", "over", 3));
  one.lesson.recording_begun();
  static_cast<void>(one.lesson.look(recording(true), "running"));
  static_cast<void>(one.lesson.look(recording(true), "over"));
  static_cast<void>(one.lesson.look(recording(false), "over"));
  EXPECT_TRUE(one.lesson.finish(one.learnt.get_future().get(), 3).empty());
  EXPECT_EQ(one.lesson.state().stage, Stage::failed);
  EXPECT_NE(one.lesson.state().sentence.find("somebody else's phone"), std::string::npos);
  EXPECT_TRUE(one.lesson.begin("phone_2.mien", "over", 3)) << "again";
}

TEST(PhoneLesson, ACancelledOneIsNotLearntFrom) {
  Class one;
  ASSERT_TRUE(one.lesson.begin("phone.mien", "paused", 3));
  one.lesson.recording_begun();
  static_cast<void>(one.lesson.look(recording(true), "running"));
  one.lesson.cancel();
  const auto next = one.lesson.look(recording(true), "running");
  EXPECT_TRUE(next.end_recording);
  EXPECT_TRUE(next.stop_prompts);
  EXPECT_EQ(one.lesson.state().stage, Stage::failed);
  static_cast<void>(one.lesson.look(recording(false), "over"));
  EXPECT_EQ(one.lesson.state().stage, Stage::failed);
  EXPECT_TRUE(one.taken.empty());
}

TEST(PhoneLesson, ARecordingThatEndsTooEarlyIsNotLearntFrom) {
  for (const char* error : {"", "the disk is full"}) {
    Class one;
    ASSERT_TRUE(one.lesson.begin("phone.mien", "over", 3));
    one.lesson.recording_begun();
    static_cast<void>(one.lesson.look(recording(true), "running"));
    EXPECT_TRUE(one.lesson.look(recording(false, error), "running").stop_prompts);
    EXPECT_EQ(one.lesson.state().stage, Stage::failed);
    EXPECT_NE(one.lesson.state().sentence, "");
    EXPECT_TRUE(one.taken.empty());
  }
}

}  // namespace
}  // namespace mien::live::phone_lesson_test
