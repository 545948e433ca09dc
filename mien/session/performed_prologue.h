#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "mien/core/time.h"
#include "mien/session/command.h"
#include "mien/take/take.h"

namespace mien::session {

/// The calibration that a performance begins with, as the command of a session's log: its steps are the
/// events "neutral", "nod", "shake", "range" and "gaze" that a virtual performer or an import wrote. None
/// without a "neutral", and none where a session made the calibration (events with "found" or "guided" among
/// their details): its log has what led to it. Beyond Calibrate::kMostSteps the later steps are left out.
[[nodiscard]] std::optional<Calibrate> performed_prologue(std::span<const take::Event> events);

/// Begins a take's log with that command, where there is one; before the take's other entries. Returns how
/// many entries it wrote, 0 or 1. `arrival`: of the first of the others, or before it.
std::int64_t begin_log(std::span<const take::Event> events, HostTime arrival, take::TakeWriter& writer);

}  // namespace mien::session
