#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/dataset_shelf.h"
#include "mien/live/recorder.h"
#include "mien/session/command.h"

namespace mien::live {

/// What a page's `begin` asks for. Errors: malformed (a field is missing), bad_usage (the performer has not
/// agreed).
[[nodiscard]] Result<DatasetWish> dataset_wish(const nlohmann::json& begin);
/// What a page is told that asked for the list.
[[nodiscard]] nlohmann::json dataset_contents_json(const DatasetShelf::Contents& contents);

/// The recording of a dataset that runs in a session, or ran last. A pure function of its calls.
class DatasetRecording {
 public:
  /// As docs/reference/page_protocol.md has it in `status.dataset`.
  struct State {
    std::string name;
    std::string performer;
    std::string take;       ///< Its file's name.
    std::size_t lines = 0;  ///< That were left when it began.
    std::size_t done = 0;   ///< That were recorded before.
    bool over = false;
    std::string error;  ///< Why it ended early; empty when it did not.
  };

  /// Begins one. Returns what the session is told, in order: that nothing is heard where the performer agreed
  /// to no sound, the consent, the pace, and what to ask for.
  /// `prompts`: as in look(); what was asked for before ends.
  /// `hears`: whether the session does; then it does again when the recording is over.
  [[nodiscard]] std::vector<session::Command> begin(const DatasetPlan& plan, std::string_view prompts,
                                                    bool hears);
  /// Its performer wants no more.
  void end() { ending_ = true; }

  /// What follows from how recording and prompts are.
  struct Next {
    bool end_recording = false;
    std::vector<session::Command> commands;  ///< For the session: that consent and asking are over.
  };
  /// To be called often. `prompts`: session::Report::Prompts::state.
  [[nodiscard]] Next look(const Recorder::State& recording, std::string_view prompts);

  /// None before the first.
  [[nodiscard]] const std::optional<State>& state() const { return state_; }

 private:
  std::optional<State> state_;
  bool ending_ = false;
  bool asked_ = false;     // Something was asked for since it began.
  bool deafened_ = false;  // The session was told to hear nothing.
};

}  // namespace mien::live
