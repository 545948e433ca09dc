#pragma once

#include <functional>
#include <span>

#include "mien/core/error.h"
#include "mien/face/output_frame.h"
#include "mien/session/receiver.h"
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

/// The same through a fresh receiver alone: samples and bindings go to the consumer as they came, commands
/// that bind or choose a device are carried out, and all other commands are passed over. Shape: entries by
/// id, ticks by after_entry. `ticked` is called at each tick; false ends the replay, which then returns
/// false.
[[nodiscard]] bool replay_samples(std::span<const take::LogEntry> entries, std::span<const take::Tick> ticks,
                                  Receiver& receiver, SampleConsumer& consumer,
                                  const std::function<bool(const take::Tick&)>& ticked);
/// The same of a take's log with its payloads, which are read as they are needed. `ticks`: the take's.
/// Errors: the take's.
[[nodiscard]] Result<bool> replay_samples(const take::Take& take, std::span<const take::Tick> ticks,
                                          Receiver& receiver, SampleConsumer& consumer,
                                          const std::function<bool(const take::Tick&)>& ticked);

}  // namespace mien::session
