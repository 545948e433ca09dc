#pragma once

#include <cstddef>
#include <functional>

#include "mien/core/error.h"
#include "mien/face/output_frame.h"
#include "mien/session/session.h"
#include "mien/take/take.h"

namespace mien::session {

/// Plays a take's log through a fresh session, as fast as it goes: every entry and every tick in the order in
/// which the session met them, which gives the bits that it gave then (with the same model and kernels).
/// `seen` is called with each frame; false stops with ErrorCode::cancelled. Errors: the take's; not_found (no
/// frames).
[[nodiscard]] Result<void> replay(
    const take::Take& take, Session& session,
    const std::function<bool(const take::Tick&, const face::OutputFrame&)>& seen);

}  // namespace mien::session
