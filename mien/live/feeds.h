#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/payload_source.h"

namespace mien::live {

class Intake;

/// A device inside this program: a microphone, a camera, or a file that is played.
struct Feed {
  std::string name;  ///< Its source in the log: "sound:talk.wav".
  /// Hands over what it has, on a thread of its own from the session's beginning on, until `stop` is set,
  /// which it looks at ten times a second or more often, or it has no more. Where it returns or throws before
  /// that the session says so and goes on.
  std::function<void(PayloadSource& out, const std::atomic<bool>& stop)> run;
};

/// A session's feeds, each with its source and its thread.
class Feeds {
 public:
  /// Before the tracker's thread begins. Errors: Intake::add_source's.
  [[nodiscard]] Result<void> open(std::vector<Feed> feeds, Intake& intake);
  /// Starts every feed. `tell`: of one that is over or failed, on its thread.
  void begin(const std::function<void(std::string kind, std::string text)>& tell);
  /// Asks them to stop, and waits for it.
  void end();
  ~Feeds() { end(); }
  Feeds() = default;
  Feeds(const Feeds&) = delete;
  Feeds& operator=(const Feeds&) = delete;

 private:
  std::vector<Feed> feeds_;
  std::vector<PayloadSource*> sources_;  // One a feed.
  std::atomic<bool> stop_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace mien::live
