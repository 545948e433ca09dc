#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/time.h"
#include "mien/take/take.h"

namespace mien::live {

/// Links that are lost and back, in words for a person. Of one that flaps a loss and a return are said at
/// once, and then, every ten seconds, how often it went meanwhile: the take has every event, a terminal has
/// room for few. A pure function of its calls.
class LinkNews {
 public:
  /// A sensor's loss that was said is not said again for this long, nor its return.
  static constexpr Duration kQuiet = std::chrono::seconds(10);

  struct Sentence {
    std::string kind;  ///< "sensor_lost" or "sensor_back".
    std::string text;  ///< "mentalis is lost".
  };

  /// Whether an event of a session is told here.
  [[nodiscard]] static bool is_about_a_link(const take::Event& event);
  /// Takes what happened at one moment (other events are passed over), and gives what is to be said now. To
  /// be called from time to time without events too: what was held back comes out then. `now` never runs
  /// back.
  [[nodiscard]] std::vector<Sentence> tell(HostTime now, std::span<const take::Event> events);

 private:
  struct Sensor {
    std::optional<HostTime> said_lost, said_back;
    bool lost = false;
    std::optional<HostTime> held_back_since;
    int losses = 0;  // Held back.
  };
  std::map<std::string, Sensor, std::less<>> sensors_;
};

}  // namespace mien::live
