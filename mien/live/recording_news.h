#pragma once

#include <string>
#include <vector>

#include "mien/live/recorder.h"

namespace mien::live {

/// What becomes of recordings, in words for a person, each thing once: a take that is written, one that ended
/// before its time, a session that cannot be recorded any more, a log that will soon be full. A pure function
/// of its calls.
class RecordingNews {
 public:
  /// One warning when the log will be full within this time, s.
  static constexpr double kLogWarning_s = 600;

  struct Sentence {
    std::string kind;  ///< "recorded", "recording_failed" or "log_fills".
    std::string text;
  };
  /// What is new since the last call.
  [[nodiscard]] std::vector<Sentence> tell(const Recorder::State& now);
  /// Another recording has begun: if it ends as the one before did, that is news.
  void begin() { error_.clear(); }

 private:
  bool was_on_ = false;
  std::string error_, unable_;
  bool warned_ = false;
};

}  // namespace mien::live
