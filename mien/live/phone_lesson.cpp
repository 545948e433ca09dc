#include "mien/live/phone_lesson.h"

#include <array>
#include <exception>
#include <utility>

#include "mien/live/asked_prompts.h"

namespace mien::live {

using session::Prompting;

std::string_view stage_name(PhoneLesson::Stage stage) {
  static constexpr std::array<std::string_view, 5> kNames = {"none", "recording", "learning", "done",
                                                             "failed"};
  return kNames.at(static_cast<std::size_t>(stage));
}

PhoneLesson::PhoneLesson(Settings settings, std::function<void(Result<TaughtByPhone>)> learnt)
    : settings_(std::move(settings)), learnt_(std::move(learnt)) {}

Result<std::vector<session::Command>> PhoneLesson::begin(const std::filesystem::path& take,
                                                         std::string_view prompts, std::int64_t calibration) {
  if (state_.stage == Stage::recording || state_.stage == Stage::learning)
    return fail(ErrorCode::bad_usage, "a phone teaches already", "learn_phone",
                "wait until it has, or cancel");
  MIEN_TRY_ASSIGN(const session::PromptScript script, settings_.script());
  state_ = {.stage = Stage::recording, .sentence = {}};
  take_ = take;
  calibration_ = calibration;
  begun_ = asked_ = over_ = cancelled_ = given_ = false;
  std::vector<session::Command> commands;
  if (asks_in(prompts)) commands.emplace_back(Prompting{Prompting::Do::stop});
  for (const session::Prompt& prompt : script.prompts) commands.emplace_back(session::AddPrompt{prompt});
  return commands;
}

void PhoneLesson::cancel() {
  if (state_.stage == Stage::learning) thread_.request_stop();
  if (state_.stage == Stage::recording || state_.stage == Stage::learning) cancelled_ = true;
}

void PhoneLesson::fail_with(std::string why) {
  state_ = {.stage = Stage::failed, .sentence = std::move(why)};
  given_ = false;
}

void PhoneLesson::refuse(const std::string& why) {
  if (given_) fail_with("what was learnt is not in force: " + why);
}

PhoneLesson::Next PhoneLesson::look(const Recorder::State& recording, std::string_view prompts) {
  if (state_.stage != Stage::recording || !begun_) return {};
  const bool asks = asks_for_pose(prompts);
  asked_ = asked_ || asks;
  if (cancelled_) {
    fail_with("cancelled; nothing was learnt");
    // Where it does not ask yet, it is about to.
    return {.end_recording = recording.on, .stop_prompts = asks || !asked_};
  }
  if (recording.on) {
    const Next next{.end_recording = asked_ && !asks && !over_, .stop_prompts = false};
    over_ = over_ || next.end_recording;
    return next;
  }
  if (!over_ || !recording.error.empty()) {
    state_ = {.stage = Stage::failed,
              .sentence = recording.error.empty() ? "the recording was ended before everything was asked for"
                                                  : recording.error};
    return {.end_recording = false, .stop_prompts = asks || !asked_};
  }
  state_.stage = Stage::learning;
  progress_ = 0;
  thread_ = std::jthread([this, take = take_](const std::stop_token& stop) {
    const auto progress = [this, &stop](double fraction, std::string_view) {
      progress_ = fraction;
      return !stop.stop_requested();
    };
    // Memory may end: nothing that is learnt ends the session.
    try {
      learnt_(settings_.learn(take, progress));
    } catch (const std::exception& error) {
      learnt_(fail(ErrorCode::internal, error.what(), take.filename().string()));
    }
  });
  return {};
}

std::vector<session::Command> PhoneLesson::finish(Result<TaughtByPhone> learnt, std::int64_t calibration) {
  if (cancelled_) {
    fail_with("cancelled; nothing was learnt");
  } else if (!learnt) {
    fail_with(learnt.error().message());
  } else if (calibration != calibration_) {
    fail_with(
        "another calibration came into force meanwhile, which what was learnt does not belong to; learn "
        "again");
  } else {
    state_.sentence = std::move(learnt->sentence);
    given_ = true;
    return {session::Correct{std::move(learnt->correction)}};
  }
  return {};
}

PhoneLesson::State PhoneLesson::state() const {
  State now = state_;
  if (now.stage == Stage::learning) now.learnt = progress_;
  return now;
}

bool PhoneLesson::in_force(bool phones_version) {
  if (!given_ || !phones_version) return false;
  given_ = false;
  state_.stage = Stage::done;
  return true;
}

}  // namespace mien::live
