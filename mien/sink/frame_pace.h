#pragma once

#include <cstdint>

#include "mien/core/time.h"

namespace mien::sink {

/// Which frames of the 60 Hz grid a sink sends, and the count of what became of them. Time is the frames'
/// own: nothing here looks at a clock.
class FramePace {
 public:
  /// `rate_hz` is 1 to 60.
  explicit FramePace(int rate_hz) : rate_hz_(rate_hz) {}

  /// Is it this frame's turn? Frames that were skipped cost nothing: the first after them goes. Call it once
  /// for each frame, before sent() or failed().
  [[nodiscard]] bool due(std::int64_t frame_index);
  void sent();         ///< The frame that was due went out.
  void failed();       ///< It did not.
  void undelivered();  ///< News of one that was counted as sent: nobody was there.

  [[nodiscard]] std::uint64_t sent_count() const { return sent_; }
  [[nodiscard]] std::uint64_t failed_count() const { return failed_; }
  /// Frames sent a second, over the last 60 frames (before there are 60, over those there are).
  [[nodiscard]] double measured_hz() const;

 private:
  static constexpr int kWindow = 60;
  int rate_hz_;
  bool begun_ = false;
  std::int64_t last_index_ = 0;
  std::int64_t last_slot_ = 0;
  std::uint64_t history_ = 0;  ///< Bit i: frame last_index_ - i was sent.
  int seen_ = 0;               ///< Frames behind history_, at most kWindow.
  std::uint64_t sent_ = 0;
  std::uint64_t failed_ = 0;
};

}  // namespace mien::sink
