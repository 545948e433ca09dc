#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/recorder.h"
#include "mien/session/command.h"
#include "mien/session/prompt_script.h"

namespace mien::live {

/// What a phone taught: what corrects the wearer's answers from then on, and what it is worth.
struct TaughtByPhone {
  model::Correction correction;
  std::string sentence;  ///< For people.
};

/// How a session learns its wearer from a phone: two guided minutes are recorded into a take, somebody learns
/// from it on a thread of its own, and what was learnt comes into force by a command of the session's log.
class PhoneLesson {
 public:
  struct Settings {
    /// What the performer is asked for. Network thread.
    std::function<Result<session::PromptScript>()> script;
    /// Learns from the take. On a thread of its own; may take half a minute.
    std::function<Result<TaughtByPhone>(const std::filesystem::path& take)> learn;
  };
  enum class Stage : std::uint8_t { none, recording, learning, done, failed };
  struct State {
    Stage stage = Stage::none;
    std::string sentence;  ///< What came of it, when done or failed.
  };

  /// `learnt` is called on the learning's thread when it is over: hand over to the network's, and call
  /// finish() there.
  PhoneLesson(Settings settings, std::function<void(Result<TaughtByPhone>)> learnt);

  /// Whether this session can: somebody learns.
  [[nodiscard]] bool can() const { return settings_.learn != nullptr && settings_.script != nullptr; }
  /// A recording into `take` has begun. Returns what the session is told, in order. `prompts`: as in look().
  /// Errors: the script's; bad_usage (it runs).
  [[nodiscard]] Result<std::vector<session::Command>> begin(const std::filesystem::path& take,
                                                            std::string_view prompts);
  /// The performer wants no more: nothing is learnt.
  void cancel();

  struct Next {
    bool end_recording = false;
    bool stop_prompts = false;
  };
  /// To be called often. `prompts`: session::Report::Prompts::state.
  [[nodiscard]] Next look(const Recorder::State& recording, std::string_view prompts);
  /// What learning came to. Returns what puts it in force; none: it failed.
  [[nodiscard]] std::vector<session::Command> finish(Result<TaughtByPhone> learnt);

  [[nodiscard]] const State& state() const { return state_; }

 private:
  Settings settings_;
  std::function<void(Result<TaughtByPhone>)> learnt_;
  State state_;
  std::filesystem::path take_;
  bool asked_ = false;  // Something was asked for since it began, ...
  bool over_ = false;   // ... and everything was.
  bool cancelled_ = false;
  std::jthread thread_;  // Last: it ends before what it uses.
};

/// As the page's protocol spells it: "recording".
[[nodiscard]] std::string_view stage_name(PhoneLesson::Stage stage);

}  // namespace mien::live
