#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mien/core/time.h"
#include "mien/live/intake.h"
#include "mien/live/sentence.h"

namespace mien::live {

/// Senders of whom more comes than is taken, but for a single burst, in words for a person: that one begins,
/// with its rate, and that it is over. What begins or ends within ten seconds of the same that was said is
/// said after them, several in one sentence: a terminal has room for few. A pure function of its calls.
class FastSenderNews {
 public:
  static constexpr Duration kQuiet = std::chrono::seconds(10);

  /// "packets_lost" or "packets_taken". `senders`: Intake::fast_senders(). From time to time, `now` never
  /// runs back.
  [[nodiscard]] std::vector<Sentence> tell(HostTime now, std::span<const Intake::FastSender> senders);

 private:
  struct Sender {
    std::string source;
    HostTime since;                  // Of the present stretch over which rates are measured, ...
    std::uint64_t sent = 0;          // ... and what had come before it, ...
    std::uint64_t dropped = 0;       // ... and been dropped.
    std::optional<HostTime> newest;  // The end of the newest stretch in which something was dropped.
    double rate_hz = 0;              // Then.
    bool told = false;
    bool here = false;
  };
  void measure(HostTime now, const Intake::FastSender& one);
  [[nodiscard]] static Sentence begun(std::span<Sender* const> senders);

  std::map<sensor::Peer, Sender> senders_;
  std::optional<HostTime> said_begun_, said_over_;
  std::vector<std::pair<sensor::Peer, std::string>> over_;  // Those that are over and not said to be.
};

}  // namespace mien::live
