#pragma once

#include <atomic>
#include <thread>

#include "mien/core/error.h"
#include "mien/live/engine.h"

namespace mien::app {

/// A session that runs on a thread of its own, for commands that perform for it meanwhile. Ends with its
/// object at the latest, whatever the command meets.
class RunningSession {
 public:
  /// Begins. The engine outlives this.
  explicit RunningSession(live::Engine& engine);
  ~RunningSession();

  /// Ends it and tells how it went. Once. Errors: the engine's; internal (something was thrown).
  [[nodiscard]] Result<live::EngineSummary> finish();

 private:
  std::atomic<bool> stop_ = false;
  Result<live::EngineSummary> summary_ = live::EngineSummary();
  std::jthread thread_;
};

}  // namespace mien::app
