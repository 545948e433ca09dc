#pragma once

#include <string>
#include <vector>

#include "mien/live/recorder.h"
#include "mien/live/sentence.h"

namespace mien::live {

/// What becomes of recordings, in words for a person, each thing once: a take that is written, one that ended
/// before its time, a session that cannot be recorded any more, a log that will soon be full. A pure function
/// of its calls.
class RecordingNews {
 public:
  /// One warning when the log will be full within this time, s.
  static constexpr double kLogWarning_s = 600;

  /// What is new since the last call: "recorded", "recording_failed" or "log_fills". `ended`: the recordings
  /// that are over since then.
  [[nodiscard]] std::vector<Sentence> tell(const Recorder::State& now,
                                           const std::vector<Recorder::Ended>& ended);

 private:
  std::string unable_;
  bool warned_ = false;
};

}  // namespace mien::live
