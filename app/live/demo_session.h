#pragma once

#include <atomic>
#include <thread>

#include "app/live/live_session.h"
#include "mien/core/error.h"
#include "mien/live/engine.h"

namespace mien::app {

/// Opens a demonstration's session and says on stderr where its page is. Where somebody else has the page's
/// port, another session perhaps, any that is free is taken. Errors: open_live's.
[[nodiscard]] Result<LiveSession> open_demo_session(LiveRequest request);

/// A session that runs on a thread of its own, for commands that perform for it meanwhile. Ends with its
/// object at the latest, whatever the command meets.
class RunningSession {
 public:
  /// Begins. The engine outlives this.
  explicit RunningSession(live::Engine& engine);
  ~RunningSession() { stop_ = true; }

  /// Ends it and tells how it went. Once. Errors: the engine's; internal (something was thrown).
  [[nodiscard]] Result<live::EngineSummary> finish();

 private:
  std::atomic<bool> stop_ = false;
  Result<live::EngineSummary> summary_ = live::EngineSummary();
  std::jthread thread_;
};

}  // namespace mien::app
