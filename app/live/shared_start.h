#pragma once

#include <atomic>
#include <chrono>
#include <optional>

namespace mien::app {

/// When a performance begins that goes out in two ways, each on a thread of its own: boards that send, and
/// cameras that are asked. The cameras say when, once the boards are ready. Thread-safe.
class SharedStart {
 public:
  using Clock = std::chrono::steady_clock;

  /// Pictures can be asked for: what was rendered first is over.
  void set_cameras_on() { cameras_on_ = true; }
  [[nodiscard]] bool cameras_on() const { return cameras_on_; }

  /// The boards' receiver has answered, or is not waited for any longer.
  void set_boards_ready() { boards_ready_ = true; }
  [[nodiscard]] bool boards_ready() const { return boards_ready_; }

  /// The performance's time 0, which lies ahead.
  void begin(Clock::time_point at) { begun_ = at; }
  [[nodiscard]] std::optional<Clock::time_point> begun() const {
    const Clock::time_point at = begun_;
    return at == Clock::time_point() ? std::nullopt : std::optional(at);
  }

  /// One of the two has failed or was stopped: the other ends, too.
  void stop() { stopped_ = true; }
  [[nodiscard]] bool stopped() const { return stopped_; }

 private:
  std::atomic<bool> cameras_on_ = false, boards_ready_ = false, stopped_ = false;
  std::atomic<Clock::time_point> begun_ = Clock::time_point();  // That: not yet.
};

}  // namespace mien::app
