#include "mien/session/replay.h"

#include <string>
#include <string_view>
#include <vector>

#include "mien/core/bytes.h"
#include "mien/session/command.h"
#include "mien/session/peers.h"
#include "mien/take/session_log.h"

namespace mien::session {
namespace {

void obey(const take::LogEntry& entry, Receiver& receiver, SampleConsumer& consumer) {
  const auto command = parse_command(as_text(entry.bytes));
  if (!command) return;
  if (const auto* bind = std::get_if<Bind>(&*command)) {
    if (const auto sensor = receiver.rig().find(bind->sensor)) receiver.bind(*sensor, bind->device, consumer);
  } else if (const auto* hear = std::get_if<Hear>(&*command)) {
    if (const auto sensor = receiver.rig().find(hear->sensor)) receiver.hear(*sensor, hear->source, consumer);
  } else if (const auto* tap = std::get_if<Tap>(&*command)) {
    if (tap->sensor.empty() || receiver.rig().find(tap->sensor)) receiver.bind_by_tap(tap->sensor);
  } else if (const auto* cover = std::get_if<Cover>(&*command)) {
    const auto sensor = receiver.rig().find(cover->sensor);
    if (cover->sensor.empty() || (sensor && receiver.rig().sensors[*sensor].camera))
      receiver.bind_by_cover(cover->sensor);
  } else if (const auto* view = std::get_if<View>(&*command)) {
    // What was refused then is refused again.
    if (const auto sensor = receiver.rig().find(view->sensor)) [[maybe_unused]]
      const auto done = receiver.change_view(*sensor, view->change, consumer);
  }
}

/// `payload_of(entry)` gives a Result<sensor::Payload>.
template <class PayloadOf>
Result<bool> play_samples(std::span<const take::LogEntry> entries, std::span<const take::Tick> ticks,
                          Receiver& receiver, SampleConsumer& consumer, PayloadOf payload_of,
                          const std::function<bool(const take::Tick&)>& ticked) {
  Peers peers;
  for (const auto& step : take::replay_order(entries, ticks)) {
    if (const take::LogEntry* entry = step.item; entry != nullptr) {
      if (entry->source == kPageSource) {
        obey(*entry, receiver, consumer);
      } else {
        MIEN_TRY_ASSIGN(const sensor::Payload payload, payload_of(*entry));
        receiver.receive_logged(entry->arrival, peers.of(entry->source), entry->bytes, payload, consumer);
      }
    }
    if (step.tick != nullptr && !ticked(*step.tick)) return false;
  }
  return true;
}

}  // namespace

Result<void> replay(const take::Take& take, Session& session,
                    const std::function<bool(const take::Tick&, const face::OutputFrame&)>& seen) {
  MIEN_TRY_ASSIGN(const std::vector<take::LogEntry> entries, take.entries());
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  if (ticks.empty())
    return fail(ErrorCode::not_found, "the take has no frames", take.path().string(), "record it again");
  MIEN_TRY_ASSIGN(take::PayloadReader payloads, take.payloads());
  Peers peers;
  for (const auto& step : take::replay_order(entries, ticks)) {
    if (const take::LogEntry* entry = step.item; entry != nullptr) {
      if (entry->source == kPageSource) {
        // What failed then fails again, and changes as little.
        [[maybe_unused]] const auto done = session.command(entry->arrival, as_text(entry->bytes));
      } else {
        MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry->id));
        session.receive_logged(entry->arrival, peers.of(entry->source), entry->bytes, payload);
      }
    }
    if (step.tick == nullptr) continue;
    if (!seen(*step.tick, session.tick(step.tick->frame, step.tick->fired)))
      return fail(ErrorCode::cancelled, "stopped", take.path().string());
  }
  return {};
}

bool replay_samples(std::span<const take::LogEntry> entries, std::span<const take::Tick> ticks,
                    Receiver& receiver, SampleConsumer& consumer,
                    const std::function<bool(const take::Tick&)>& ticked) {
  const auto none = [](const take::LogEntry&) -> Result<sensor::Payload> { return sensor::Payload(); };
  return *play_samples(entries, ticks, receiver, consumer, none, ticked);
}

Result<bool> replay_samples(std::span<const take::LogEntry> entries, std::span<const take::Tick> ticks,
                            take::PayloadReader& payloads, Receiver& receiver, SampleConsumer& consumer,
                            const std::function<bool(const take::Tick&)>& ticked) {
  const auto stored = [&](const take::LogEntry& entry) { return payloads.of(entry.id); };
  return play_samples(entries, ticks, receiver, consumer, stored, ticked);
}

}  // namespace mien::session
