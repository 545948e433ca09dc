#pragma once

#include "app/live/live_session.h"
#include "mien/core/error.h"

namespace mien::app {

/// Opens a demonstration's session and says on stderr where its page is. Where somebody else has the page's
/// port, another session perhaps, any that is free is taken. Errors: open_live's.
[[nodiscard]] Result<LiveSession> open_demo_session(LiveRequest request);

}  // namespace mien::app
