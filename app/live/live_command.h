#pragma once

#include <cstdio>
#include <string>

#include "app/command_line.h"
#include "app/live/live_session.h"
#include "mien/core/error.h"
#include "mien/live/engine.h"

// What `mien live` and `mien record` share: options, and what is said of a session.
namespace mien::app {

/// The options of every command that opens a session. Returns --listen, for what excludes it.
Option add_session_options(Command command, LiveRequest& request);

/// What the temporary log takes of its limit, and for how long there is room: "0.332 of 4 GB, 3.1 h left".
[[nodiscard]] std::string log_text(const live::Spool::Usage& log);

/// Where it listens and sends, where its page is, and how it ends.
void print_opening(std::FILE* out, const LiveSession& session);

/// Prints how it went, in words or as one JSON object. Errors: io (the take is not whole; no frame came).
[[nodiscard]] Result<void> print_closing(const live::EngineSummary& summary, bool json);

}  // namespace mien::app
