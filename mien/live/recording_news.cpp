#include "mien/live/recording_news.h"

#include <fmt/format.h>

#include <cmath>

namespace mien::live {

std::vector<Sentence> RecordingNews::tell(const Recorder::State& now,
                                          const std::vector<Recorder::Ended>& ended) {
  std::vector<Sentence> news;
  bool failed = false;
  for (const Recorder::Ended& one : ended) {
    failed = failed || !one.error.empty();
    if (one.error.empty())
      news.push_back({"recorded", one.path.string() + " is written"});
    else
      news.push_back({"recording_failed", "the recording ended: " + one.error + "; the capture goes on"});
  }
  // Where both are so, the one is why the other is.
  if (now.unable != unable_ && !failed)
    news.push_back({"recording_failed", "this session cannot be recorded: " + now.unable});
  unable_ = now.unable;
  if (!warned_ && now.unable.empty() && now.log.seconds_left && *now.log.seconds_left < kLogWarning_s) {
    warned_ = true;
    news.push_back(
        {"log_fills", fmt::format("the session's log is full in {:.0f} minutes; from then on the session "
                                  "cannot be recorded (--log-limit)",
                                  std::ceil(*now.log.seconds_left / 60))});
  }
  return news;
}

}  // namespace mien::live
