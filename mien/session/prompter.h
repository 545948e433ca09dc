#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/session/prompt.h"
#include "mien/take/take.h"

namespace mien::session {

/// Asks for poses one after the other, on the grid's time: so a replay of a session's log asks at the same
/// frames again, and a take's events come out the same. Nothing is asked for while there are no frames. A
/// pose that was shown to its end leaves an event; one that was skipped, interrupted by a pause or cut off by
/// the session's end leaves none.
class Prompter {
 public:
  /// The performer gets ready before the first pose, and when it goes on after a pause.
  static constexpr Duration kLeadIn = std::chrono::seconds(3);

  /// One more, after those before. Errors: check_prompt's; out_of_range (kMaxPrompts).
  [[nodiscard]] Result<void> add(Prompt prompt);
  /// Goes to the next pose now. Errors: not_found (none is asked for).
  [[nodiscard]] Result<void> skip();
  /// Stops asking, and goes on with the pose that was interrupted, from its beginning. Errors: as skip().
  [[nodiscard]] Result<void> pause(bool paused);
  /// Asks for none of the rest. Errors: as skip().
  [[nodiscard]] Result<void> stop();

  /// At each tick, in order. Returns the event of a pose that was over at it.
  std::optional<take::Event> at(DeviceTime frame);

  enum class State { none, ready, running, paused, over };
  /// Where it is at a frame.
  struct Place {
    State state = State::none;
    const Prompt* prompt = nullptr;  ///< What is asked for, or comes next when ready or paused.
    const Prompt* next = nullptr;    ///< After it.
    std::size_t number = 0;          ///< Of `prompt`, from 1; when over, how many there were.
    std::size_t of = 0;
    double progress = 0;   ///< Of `prompt`, 0 to 1.
    Duration remaining{};  ///< Of `prompt`, or until it begins.
    Duration left{};       ///< Until all are over, without pauses.
  };
  [[nodiscard]] Place place(DeviceTime frame) const;

 private:
  [[nodiscard]] Result<void> check_asking() const;

  std::vector<Prompt> prompts_;
  std::size_t now_ = 0;              // Index; beyond the last when all are over.
  std::optional<DeviceTime> begin_;  // Of the present one; none until the next tick.
  Duration lead_in_ = kLeadIn;       // Before it, from that tick.
  bool paused_ = false;
};

}  // namespace mien::session
