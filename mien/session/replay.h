#pragma once

#include <functional>
#include <span>

#include "mien/core/error.h"
#include "mien/face/output_frame.h"
#include "mien/session/session.h"
#include "mien/take/take.h"

namespace mien::session {

/// Called with each frame of a replay; false ends the replay.
using Seen = std::function<bool(const take::Tick&, const face::OutputFrame&)>;

/// Plays a take's log through a fresh session, as fast as it goes: every entry and every tick in the order in
/// which the session met them, which gives the bits that it gave then (with the same model and kernels). A
/// performance whose log does not begin with its calibration, as takes had it before, is calibrated by its
/// events (performed_prologue()). Errors: the take's; not_found (no frames); cancelled (`seen` said so).
[[nodiscard]] Result<void> replay(const take::Take& take, Session& session, const Seen& seen);

/// The same of a log in memory, without payloads: of a performance that begins with the calibration of
/// `events`. Shape: entries by id, ticks by after_entry. Whether `seen` never ended it.
bool replay(std::span<const take::Event> events, std::span<const take::LogEntry> entries,
            std::span<const take::Tick> ticks, Session& session, const Seen& seen);

}  // namespace mien::session
