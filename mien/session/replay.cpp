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

/// What a receiver makes of an entry.
void receive(const take::LogEntry& entry, const sensor::Payload& payload, Peers& peers, Receiver& receiver,
             SampleConsumer& consumer) {
  if (entry.source == kPageSource)
    obey(entry, receiver, consumer);
  else
    receiver.receive_logged(entry.arrival, peers.of(entry.source), entry.bytes, payload, consumer);
}

/// A take's log in the session's order (take::ReplayOrder), one entry in memory at a time. `received(entry,
/// payload)` and `ticked(tick)`, which ends it by false.
template <class Received, class Ticked>
Result<bool> play_log(const take::Take& take, std::span<const take::Tick> ticks, const Received& received,
                      const Ticked& ticked) {
  MIEN_TRY_ASSIGN(take::EntryReader log, take.log());
  MIEN_TRY_ASSIGN(take::PayloadReader payloads, take.payloads());
  for (;;) {
    MIEN_TRY_ASSIGN(const take::LogEntry* const entry, log.next());
    for (; !ticks.empty() && (entry == nullptr || ticks.front().after_entry < entry->id);
         ticks = ticks.subspan(1))
      if (!ticked(ticks.front())) return false;
    if (entry == nullptr) return true;
    MIEN_TRY_ASSIGN(const sensor::Payload payload, payloads.of(entry->id));
    received(*entry, payload);
  }
}

}  // namespace

Result<void> replay(const take::Take& take, Session& session,
                    const std::function<bool(const take::Tick&, const face::OutputFrame&)>& seen) {
  MIEN_TRY_ASSIGN(const std::vector<take::Tick> ticks, take.ticks());
  if (ticks.empty())
    return fail(ErrorCode::not_found, "the take has no frames", take.path().string(), "record it again");
  Peers peers;
  const auto received = [&](const take::LogEntry& entry, const sensor::Payload& payload) {
    if (entry.source == kPageSource) {
      // What failed then fails again, and changes as little.
      [[maybe_unused]] const auto done = session.command(entry.arrival, as_text(entry.bytes));
    } else {
      session.receive_logged(entry.arrival, peers.of(entry.source), entry.bytes, payload);
    }
  };
  MIEN_TRY_ASSIGN(const bool whole, play_log(take, ticks, received, [&](const take::Tick& tick) {
                    return seen(tick, session.tick(tick.frame, tick.fired));
                  }));
  if (!whole) return fail(ErrorCode::cancelled, "stopped", take.path().string());
  return {};
}

bool replay_samples(std::span<const take::LogEntry> entries, std::span<const take::Tick> ticks,
                    Receiver& receiver, SampleConsumer& consumer,
                    const std::function<bool(const take::Tick&)>& ticked) {
  Peers peers;
  for (const auto& step : take::replay_order(entries, ticks)) {
    if (step.item != nullptr) receive(*step.item, {}, peers, receiver, consumer);
    if (step.tick != nullptr && !ticked(*step.tick)) return false;
  }
  return true;
}

Result<bool> replay_samples(const take::Take& take, std::span<const take::Tick> ticks, Receiver& receiver,
                            SampleConsumer& consumer, const std::function<bool(const take::Tick&)>& ticked) {
  Peers peers;
  return play_log(
      take, ticks,
      [&](const take::LogEntry& entry, const sensor::Payload& payload) {
        receive(entry, payload, peers, receiver, consumer);
      },
      ticked);
}

}  // namespace mien::session
