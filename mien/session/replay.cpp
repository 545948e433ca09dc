#include "mien/session/replay.h"

#include <map>
#include <string>
#include <vector>

#include "mien/take/session_log.h"

namespace mien::session {

Result<void> replay(const take::Take& take, Session& session,
                    const std::function<bool(const take::Tick&, const face::OutputFrame&)>& seen) {
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  if (ticks.empty())
    return fail(ErrorCode::not_found, "the take has no frames", take.path().string(), "record it again");
  std::map<std::string, sensor::Peer> peers;  // In the order of their first words, as live.
  for (const auto& step : take::replay_order(entries, ticks)) {
    if (step.item != nullptr) {
      const take::LogEntry& entry = *step.item;
      if (entry.source == kPageSource) {
        // What failed then fails again, and changes as little.
        [[maybe_unused]] const auto done = session.command(
            entry.arrival, {reinterpret_cast<const char*>(entry.bytes.data()), entry.bytes.size()});
      } else {
        const auto peer = peers.emplace(entry.source, static_cast<sensor::Peer>(peers.size())).first;
        session.receive(entry.arrival, peer->second, entry.bytes);
      }
    }
    if (step.tick == nullptr) continue;
    if (!seen(*step.tick, session.tick(step.tick->frame, step.tick->fired)))
      return fail(ErrorCode::cancelled, "stopped", take.path().string());
  }
  return {};
}

}  // namespace mien::session
