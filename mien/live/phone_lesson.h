#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
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
    /// Learns from the take. On a thread of its own; may take half a minute, less when it is to stop.
    std::function<Result<TaughtByPhone>(const std::filesystem::path& take, const Progress& progress)> learn;
  };
  enum class Stage : std::uint8_t { none, recording, learning, done, failed };
  struct State {
    Stage stage = Stage::none;
    std::string sentence;  ///< What came of it, when done or failed.
    double learnt = 0;     ///< While learning: how much of that is done, 0 to 1.
  };

  /// `learnt` is called on the learning's thread when it is over: hand over to the network's, and call
  /// finish() there.
  PhoneLesson(Settings settings, std::function<void(Result<TaughtByPhone>)> learnt);

  /// Whether this session can: somebody learns.
  [[nodiscard]] bool can() const { return settings_.learn != nullptr && settings_.script != nullptr; }
  /// A recording into `take` is about to begin, with this calibration in force. Returns what the session is
  /// told then, in order. `prompts`: as in look(). Errors: the script's; bad_usage (it runs).
  [[nodiscard]] Result<std::vector<session::Command>> begin(const std::filesystem::path& take,
                                                            std::string_view prompts,
                                                            std::int64_t calibration);
  /// It has begun: from now on look() judges by what it is told of it.
  void recording_begun() { begun_ = true; }
  /// The performer wants no more: nothing is learnt, or comes into force.
  void cancel();
  [[nodiscard]] bool is_cancelled() const { return cancelled_; }
  /// It comes to nothing, for this reason.
  void fail_with(std::string why);
  /// The session refused a command. Only what was learnt is waited for.
  void refuse(const std::string& why);

  struct Next {
    bool end_recording = false;
    bool stop_prompts = false;
  };
  /// To be called often. `prompts`: session::Report::Prompts::state.
  [[nodiscard]] Next look(const Recorder::State& recording, std::string_view prompts);
  /// What learning came to. Returns what puts it in force; none: it failed. `calibration`: in force now.
  [[nodiscard]] std::vector<session::Command> finish(Result<TaughtByPhone> learnt, std::int64_t calibration);
  /// To be called often: whether a phone's version is in force. Returns true once, when that is what was
  /// waited for.
  [[nodiscard]] bool in_force(bool phones_version);

  [[nodiscard]] State state() const;

 private:
  Settings settings_;
  std::function<void(Result<TaughtByPhone>)> learnt_;
  State state_;
  std::filesystem::path take_;
  bool begun_ = false;  // The recording.
  bool asked_ = false;  // Something was asked for since it began, ...
  bool over_ = false;   // ... and everything was.
  bool cancelled_ = false;
  bool given_ = false;  // What was learnt, to the session.
  std::int64_t calibration_ = 0;
  std::atomic<double> progress_ = 0;
  std::jthread thread_;  // Last: it ends before what it uses.
};

/// As the page's protocol spells it: "recording".
[[nodiscard]] std::string_view stage_name(PhoneLesson::Stage stage);

}  // namespace mien::live
