#include "mien/live/phone_lesson.h"

#include <array>
#include <utility>

namespace mien::live {
namespace {

using session::Prompting;

/// Whether a session in this state of its prompts asks for one.
bool still_asks(std::string_view prompts) {
  return prompts == "ready" || prompts == "running" || prompts == "paused";
}

}  // namespace

std::string_view stage_name(PhoneLesson::Stage stage) {
  static constexpr std::array<std::string_view, 5> kNames = {"none", "recording", "learning", "done",
                                                             "failed"};
  return kNames.at(static_cast<std::size_t>(stage));
}

PhoneLesson::PhoneLesson(Settings settings, std::function<void(Result<TaughtByPhone>)> learnt)
    : settings_(std::move(settings)), learnt_(std::move(learnt)) {}

Result<std::vector<session::Command>> PhoneLesson::begin(const std::filesystem::path& take,
                                                         std::string_view prompts) {
  if (state_.stage == Stage::recording || state_.stage == Stage::learning)
    return fail(ErrorCode::bad_usage, "a phone teaches already", "learn_phone",
                "wait until it has, or cancel");
  MIEN_TRY_ASSIGN(const session::PromptScript script, settings_.script());
  state_ = {.stage = Stage::recording, .sentence = {}};
  take_ = take;
  asked_ = over_ = cancelled_ = false;
  std::vector<session::Command> commands;
  if (still_asks(prompts) || prompts == "block") commands.emplace_back(Prompting{Prompting::Do::stop});
  for (const session::Prompt& prompt : script.prompts) commands.emplace_back(session::AddPrompt{prompt});
  return commands;
}

void PhoneLesson::cancel() {
  if (state_.stage == Stage::recording) cancelled_ = true;
}

PhoneLesson::Next PhoneLesson::look(const Recorder::State& recording, std::string_view prompts) {
  if (state_.stage != Stage::recording) return {};
  const bool asks = still_asks(prompts);
  asked_ = asked_ || asks;
  if (cancelled_) {
    state_ = {.stage = Stage::failed, .sentence = "cancelled; nothing was learnt"};
    return {.end_recording = recording.on, .stop_prompts = asks};
  }
  if (recording.on) {
    const Next next{.end_recording = asked_ && !asks && !over_, .stop_prompts = false};
    over_ = over_ || next.end_recording;
    return next;
  }
  if (!over_) {
    state_ = {.stage = Stage::failed,
              .sentence = recording.error.empty() ? "the recording was ended before everything was asked for"
                                                  : recording.error};
    return {.end_recording = false, .stop_prompts = asks};
  }
  state_.stage = Stage::learning;
  thread_ = std::jthread([this, take = take_] { learnt_(settings_.learn(take)); });
  return {};
}

std::vector<session::Command> PhoneLesson::finish(Result<TaughtByPhone> learnt) {
  if (!learnt) {
    state_ = {.stage = Stage::failed, .sentence = learnt.error().message()};
    return {};
  }
  state_ = {.stage = Stage::done, .sentence = std::move(learnt->sentence)};
  return {session::Correct{std::move(learnt->correction)}};
}

}  // namespace mien::live
