#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/live/feeds.h"
#include "mien/speech/block_maker.h"

namespace mien::app {

/// How far a stream of sound is behind the machine's clock, beside what it usually is: a card's clock is not
/// the machine's, so what grows slowly is drift, and what jumps was lost or held up.
class Lateness {
 public:
  using Clock = std::chrono::steady_clock;
  explicit Lateness(Clock::time_point now) : begun_(now), newest_(now) {}
  /// Seconds, when `position_s` of the stream have been heard; below 0: ahead.
  [[nodiscard]] double at(double position_s, Clock::time_point now) const;
  /// The stream goes on from there: over some ten seconds it becomes what is usual.
  void follow(double position_s, Clock::time_point now);

 private:
  [[nodiscard]] double behind_s(double position_s, Clock::time_point now) const;

  Clock::time_point begun_;
  Clock::time_point newest_;
  double usual_s_ = 0;
};

/// What a microphone hears, on its way into the session: in blocks of 20 ms that are numbered on the
/// machine's clock, so that no time is lost over gaps; that it stays silent is told. It alone says what the
/// feed's trouble is, so that neither a silence nor what the feed itself meets hides that the other goes on.
/// One thread.
class HeardSound {
 public:
  using Clock = std::chrono::steady_clock;
  /// A stream that is silent for so long is told of.
  static constexpr auto kSilent = std::chrono::seconds(5);

  /// `name`: of the microphone, as it is told. `device`: whose blocks they are. `port` outlives this.
  HeardSound(std::string name, std::uint64_t device, live::FeedPort& port, Clock::time_point now)
      : name_(std::move(name)), device_(device), port_(port), begun_(now), quiet_since_(now) {}

  /// A stream begins, of which no silence is known: its first block is the one of now. Errors:
  /// BlockMaker::create's.
  [[nodiscard]] Result<void> begin(int rate_hz, Clock::time_point now);
  /// Its next samples, -1 to 1. After begin().
  void push(std::span<const float> samples, Clock::time_point now);
  /// So many samples of the stream are missing before what comes next: whole blocks are left out, and the
  /// rest is silence.
  void skip(std::uint64_t samples, Clock::time_point now);
  /// The next block is the one of now, or a later one.
  void catch_up(Clock::time_point now);
  /// What else than silence stands against hearing, and is told rather than it; empty: nothing does any more.
  void trouble(std::string text);
  /// Nobody is to be heard any more: nothing stands against it.
  void over();

 private:
  void watch_silence(std::span<const float> samples, Clock::time_point now);
  void publish();
  void hand_over(const speech::Block& block, Clock::time_point now);
  [[nodiscard]] std::uint64_t block_at(Clock::time_point now) const;

  std::string name_;
  std::uint64_t device_;
  live::FeedPort& port_;
  Clock::time_point begun_;
  std::optional<speech::BlockMaker> maker_;
  std::uint64_t rate_hz_ = 0;
  std::uint64_t next_block_ = 0;
  bool first_ = true;  // No block of this stream was handed over.
  Clock::time_point quiet_since_;
  std::string silent_;  // That it is, as it was told; empty: it is not.
  std::string other_;   // What trouble() was given.
};

}  // namespace mien::app
