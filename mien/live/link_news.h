#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/time.h"
#include "mien/live/sentence.h"
#include "mien/take/take.h"

namespace mien::live {

/// Links that are lost and back, and faces that a sensor sees no more and again, in words for a person. Of
/// one that flaps a loss and a return are said at once, and then, every ten seconds, how often it went
/// meanwhile: the take has every event, a terminal has room for few. A pure function of its calls.
class LinkNews {
 public:
  /// A loss that was said is not said again for this long, nor its return.
  static constexpr Duration kQuiet = std::chrono::seconds(10);

  /// How the loss of one sensor is said, unless others are lost at once or it flaps.
  [[nodiscard]] static std::string loss_text(std::string_view sensor);

  /// Whether an event of a session is told here.
  [[nodiscard]] static bool is_about_a_link(const take::Event& event);
  /// Takes what happened at one moment (other events are passed over), and gives what is to be said now, of
  /// the kind of the newest event in it. To be called from time to time without events too: what was held
  /// back comes out then. `now` never runs back.
  [[nodiscard]] std::vector<Sentence> tell(HostTime now, std::span<const take::Event> events);

 private:
  struct Sensor {
    std::optional<HostTime> said_lost, said_back;
    bool lost = false;
    std::optional<HostTime> held_back_since;
    int losses = 0;  // Held back.
  };
  std::array<std::map<std::string, Sensor>, 2> sensors_;  // Whose links, and whose faces, were ever lost.
};

}  // namespace mien::live
