#include "mien/sink/frame_pace.h"

#include <algorithm>
#include <bit>

namespace mien::sink {

bool FramePace::due(std::int64_t frame_index) {
  const auto grid = static_cast<std::int64_t>(kFrameRateHz);
  const std::int64_t second = frame_index / grid - (frame_index % grid < 0 ? 1 : 0);
  const std::int64_t slot = second * rate_hz_ + (frame_index - second * grid) * rate_hz_ / grid;
  // Backwards (a replay was set back) is a beginning of its own.
  const bool again = begun_ && frame_index > last_index_;
  const std::int64_t step = again ? std::min<std::int64_t>(frame_index - last_index_, kWindow) : kWindow;
  history_ = (step >= kWindow ? 0 : history_ << step) & ((std::uint64_t{1} << kWindow) - 1);
  seen_ = again ? std::min(seen_ + static_cast<int>(step), kWindow) : 1;
  const bool turn = !again || slot != last_slot_;
  begun_ = true;
  last_index_ = frame_index;
  last_slot_ = slot;
  return turn;
}

void FramePace::sent() {
  ++sent_;
  history_ |= 1;
}

void FramePace::failed() {
  ++failed_;
}

void FramePace::undelivered() {
  ++failed_;
  if (sent_ > 0) --sent_;
  history_ &= history_ - 1;  // The latest that was sent.
}

double FramePace::measured_hz() const {
  return seen_ == 0 ? 0 : kFrameRateHz * std::popcount(history_) / seen_;
}

}  // namespace mien::sink
