#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "app/live/heard_sound.h"
#include "mien/core/error.h"
#include "mien/live/feeds.h"
#include "mien/speech/sound_message.h"

namespace mien::app {

/// What a browser's messages become: sound, where they are what they claim to be. Refused are messages that
/// cannot be read, that repeat what was heard, that stand more than kOff_s from the machine's clock, and more
/// than about real time of them. One thread.
class PageSound {
 public:
  using Clock = HeardSound::Clock;
  /// So far a message may be from where it should stand, and so much may come at once, s of sound.
  static constexpr double kOff_s = 1;
  /// Who sends nothing but what stands elsewhere is taken at its word after so long.
  static constexpr auto kPatience = std::chrono::seconds(2);
  /// A browser that was let in and sends nothing for so long is told of.
  static constexpr auto kGone = std::chrono::seconds(3);

  /// `device`: whose blocks they are. `port` outlives this.
  PageSound(std::uint64_t device, live::FeedPort& port, Clock::time_point now);

  /// A message of a client; false: refused, with the first reason of each client told.
  bool take(std::uint64_t client, std::span<const std::byte> bytes, Clock::time_point now);
  /// Ten times a second or more often. `admitted`: whose messages are to come; 0: nobody's.
  void look(std::uint64_t admitted, Clock::time_point now);

 private:
  struct Stream {
    std::uint64_t client = 0;
    int rate_hz = 0;
    std::uint64_t first = 0;  // Its first sample's count.
    std::uint64_t next = 0;   // The count that should come next.
    Lateness lateness;
    std::optional<Clock::time_point> off_since;  // What comes stands elsewhere since then.

    [[nodiscard]] double position_s(std::uint64_t count) const {
      return (static_cast<double>(count) - static_cast<double>(first)) / rate_hz;
    }
  };
  bool refuse(std::uint64_t client, Error why);
  bool pay(const speech::SoundMessage& message, Clock::time_point now);
  Result<void> begin(std::uint64_t client, const speech::SoundMessage& message, Clock::time_point now);
  void hear(const speech::SoundMessage& message, Clock::time_point now);

  live::FeedPort& port_;
  HeardSound heard_;
  std::optional<Stream> stream_;
  double allowance_s_ = kOff_s;  // Sound that may come now.
  Clock::time_point paid_;
  std::vector<float> samples_;
  std::uint64_t told_ = 0;      // The client whose refusal was told.
  std::uint64_t admitted_ = 0;  // As it was last, ...
  Clock::time_point newest_;    // ... and when it was let in or heard.
  bool troubled_ = false;       // A trouble was told that the next sound ends.
};

/// A browser's microphone: what the client of the page that the session lets in sends
/// (docs/reference/page_protocol.md). `device`: whose blocks they are.
[[nodiscard]] live::Feed page_feed(std::uint64_t device);

}  // namespace mien::app
