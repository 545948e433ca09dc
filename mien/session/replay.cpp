#include "mien/session/replay.h"

#include <vector>

#include "mien/core/bytes.h"
#include "mien/session/command.h"
#include "mien/session/performed_prologue.h"

namespace mien::session {
namespace {

/// What a session makes of an entry.
void receive(const take::LogEntry& entry, const sensor::Payload& payload, Peers& peers, Session& session) {
  if (entry.source == kPageSource)
      // What failed then fails again, and changes as little.
      [[maybe_unused]]
    const auto done = session.command(entry.arrival, as_text(entry.bytes));
  else
    session.receive_logged(entry.arrival, peers.of(entry.source), entry.bytes, payload);
}

void calibrate_by(std::span<const take::Event> events, Session& session) {
  if (const auto prologue = performed_prologue(events)) [[maybe_unused]]
    const auto done = session.command({}, write_command(*prologue));
}

}  // namespace

Result<void> replay(const take::Take& take, Session& session, const Seen& seen) {
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  if (ticks.empty())
    return fail(ErrorCode::not_found, "the take has no frames", take.path().string(),
                "record or perform it again");
  MIEN_TRY_ASSIGN(const std::vector<take::Event> events, take.events());
  MIEN_TRY_ASSIGN(take::EntryReader log, take.log());
  MIEN_TRY_ASSIGN(take::PayloadReader payloads, take.payloads());
  Peers peers;
  auto tick = ticks.begin();
  for (bool begins = true;; begins = false) {
    MIEN_TRY_ASSIGN(const take::LogEntry* const entry, log.next());
    if (begins && (entry == nullptr || entry->source != kPageSource)) calibrate_by(events, session);
    for (; tick != ticks.end() && (entry == nullptr || tick->after_entry < entry->id); ++tick)
      if (!seen(*tick, session.tick(tick->frame, tick->fired)))
        return fail(ErrorCode::cancelled, "stopped", take.path().string());
    if (entry == nullptr) return {};
    MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry->id));
    receive(*entry, payload, peers, session);
  }
}

bool replay(std::span<const take::Event> events, std::span<const take::LogEntry> entries,
            std::span<const take::Tick> ticks, Session& session, const Seen& seen) {
  Peers peers;
  calibrate_by(events, session);
  auto entry = entries.begin();
  for (const take::Tick& tick : ticks) {
    for (; entry != entries.end() && entry->id <= tick.after_entry; ++entry)
      receive(*entry, {}, peers, session);
    if (!seen(tick, session.tick(tick.frame, tick.fired))) return false;
  }
  for (; entry != entries.end(); ++entry) receive(*entry, {}, peers, session);
  return true;
}

}  // namespace mien::session
