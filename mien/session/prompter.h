#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/session/prompt.h"

namespace mien::session {

/// Asks for poses and lines one after the other, on the grid's time: so a replay of a session's log asks at
/// the same frames again, and a take's events come out the same. Nothing is asked for while there are no
/// frames. What was shown to its end is told of; what was skipped, interrupted by a pause or cut off by the
/// session's end is not.
///
/// Prompts of a block (Prompt::block) wait before its first one until it is begun, and so do all that are
/// asked for again. One at the performer's own pace is shown until go_on(), or, where the voice is followed,
/// until it was spoken and silence came.
class Prompter {
 public:
  /// The performer gets ready before the first prompt, before a block's first, and when it goes on after a
  /// pause.
  static constexpr Duration kLeadIn = std::chrono::seconds(3);
  /// A text was read once the voice was heard for this share of the time that it usually takes (less a
  /// second, in which nobody speaks yet), and has been silent for kSilent.
  static constexpr double kSpokenShare = 0.4;
  static constexpr Duration kSilent = std::chrono::milliseconds(1200);
  /// What is shown at the performer's own pace for so long is interrupted by a pause: nobody is there.
  static constexpr Duration kLongest = std::chrono::minutes(10);

  /// One more, after those before. Errors: check_prompt's; out_of_range (kMaxPrompts).
  [[nodiscard]] Result<void> add(Prompt prompt);
  /// Goes to the next prompt now. Errors: not_found (none is asked for).
  [[nodiscard]] Result<void> skip();
  /// Stops asking, and goes on with the prompt that was interrupted, from its beginning. Errors: as skip().
  [[nodiscard]] Result<void> pause(bool paused);
  /// Asks for none of the rest. Errors: as skip().
  [[nodiscard]] Result<void> stop();
  /// Begins the block that waits. Errors: as skip(); bad_usage (none waits).
  [[nodiscard]] Result<void> begin_block();
  /// The prompt that is shown is over, at the next tick. Errors: as skip(); bad_usage (none is shown, or it
  /// has a pace of its own).
  [[nodiscard]] Result<void> go_on();
  /// The prompt that is shown from its beginning; in its first second, or while none is shown, the one before
  /// it in its block. Errors: as skip().
  [[nodiscard]] Result<void> repeat();
  /// Whether texts are over when they were spoken, too.
  void follow_voice(bool follow) { by_voice_ = follow; }

  /// What was shown from `begin` to `end`.
  struct Shown {
    Prompt prompt;
    DeviceTime begin, end;
  };
  /// At each tick, in order. `speaks`: somebody does. Returns what was over at it.
  std::optional<Shown> at(DeviceTime frame, bool speaks = false);
  /// What was shown was poor: it is asked for once more, after all others, unless it was kMaxAttempts times,
  /// is already to come, or was accepted before. Returns whether it is.
  bool ask_again(const Prompt& prompt);
  /// What was shown was good: it need not be asked for again.
  void accept(const Prompt& prompt);

  enum class State { none, ready, running, paused, over, block };
  /// Where it is at a frame.
  struct Place {
    State state = State::none;
    const Prompt* prompt = nullptr;  ///< What is asked for, or comes next when ready, paused or waiting.
    const Prompt* next = nullptr;    ///< After it.
    DeviceTime begin;                ///< Of `prompt`, when running.
    std::size_t number = 0;          ///< Of `prompt`, from 1; when over, how many there were.
    std::size_t of = 0;
    std::size_t again = 0;  ///< Of those after `prompt`, asked for again.
    double progress = 0;    ///< Of `prompt`, 0 to 1.
    Duration remaining{};   ///< Of `prompt`, or until it begins.
    Duration left{};        ///< Until all are over, without pauses.
  };
  [[nodiscard]] Place place(DeviceTime frame) const;

 private:
  [[nodiscard]] Result<void> check_asking() const;
  /// Whether the present one waits for its block to be begun.
  [[nodiscard]] bool waits() const;
  void restart(Duration lead_in);
  [[nodiscard]] bool is_running() const { return begin_ && *begin_ <= newest_ && !paused_; }
  /// Whether the present one has been spoken, with this tick.
  bool is_spoken(DeviceTime frame, bool speaks);

  std::vector<Prompt> prompts_;      // Of the recording that runs, or ran last.
  std::vector<Prompt> accepted_;     // Lines of these.
  std::size_t now_ = 0;              // Index; beyond the last when all are over.
  std::optional<DeviceTime> begin_;  // Of the present one; none until the next tick.
  DeviceTime newest_;                // Tick.
  Duration lead_in_ = kLeadIn;       // Before it, from that tick.
  bool paused_ = false;
  bool goes_on_ = false;  // go_on() since the last tick.
  std::string begun_;     // The block that was begun last, as block_key() has it.
  bool by_voice_ = false;
  Duration spoken_{};                  // Of the present one.
  std::optional<DeviceTime> silence_;  // Since when nobody speaks.
};

}  // namespace mien::session
