#pragma once

#include <functional>
#include <string>

#include "app/command_line.h"
#include "app/live/live_session.h"
#include "mien/core/error.h"
#include "mien/live/engine.h"

// What `mien live` and `mien record` share: options, and how a session is run.
namespace mien::app {

/// The options of every command that opens a session. Returns --listen, for what excludes it.
Option add_session_options(Command command, LiveRequest& request);

/// Says where the session listens and sends, where its page is, and how it ends, then `more`, where there is
/// some; runs it, telling what a person should see at once; prints how it went, in words or as one JSON
/// object. `seen`: as live::EngineListener has it. Errors: the engine's; io (the take is not whole; no frame
/// came).
[[nodiscard]] Result<void> run_session(const LiveSession& session, bool json, const std::string& more = {},
                                       const std::function<void(const live::Status&)>& seen = {});

}  // namespace mien::app
