#include "mien/live/recording_news.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace mien::live {

std::vector<RecordingNews::Sentence> RecordingNews::tell(const Recorder::State& now) {
  std::vector<Sentence> news;
  if (was_on_ && !now.on && now.error.empty())
    news.push_back({"recorded", now.path.string() + " is written"});
  was_on_ = now.on;
  if (now.error != error_) {
    error_ = now.error;
    if (!error_.empty())
      news.push_back({"recording_failed", "the recording ended: " + error_ + "; the capture goes on"});
  } else if (now.unable != unable_ && now.error.empty()) {
    news.push_back({"recording_failed", "this session cannot be recorded: " + now.unable});
  }
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
