#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "mien/core/error.h"
#include "mien/session/report.h"

// What a running session says (docs/reference/page_protocol.md), read back as far as a terminal has use for
// it.
namespace mien::app {

struct SessionStatus {
  /// A sensor of the rig.
  struct Link {
    std::string sensor;
    std::string state;  ///< As sensor::link_state_name() spells it, or a later version does.
    /// Whether something is measured by it: it is neither unbound nor silent nor lost, and sees a face.
    [[nodiscard]] bool received() const;
  };

  double time_s = 0;  ///< Of the newest frame, on the reference's time line.
  std::vector<Link> links;
  /// As the session reports it, without `target` and the versions' own JSON.
  session::Report::Calibration calibration;
  /// State of what is asked for, as session::Report::Prompts has it; empty: nothing is.
  std::string prompts;
  /// The dataset's recording that runs, or ran last.
  struct Dataset {
    std::string take;  ///< Its file's name.
    bool over = false;
    std::string error;  ///< Why it ended early; empty when it did not.
  };
  std::optional<Dataset> dataset;  ///< None before the first.
};

struct SessionReply {
  std::int64_t id = 0;  ///< Of the command that is answered.
  std::string error;    ///< One line; empty when it was done.
};

struct SessionEvent {
  std::string kind;  ///< "recentre_failed", "sensor_lost", ...
  std::string text;
};

/// monostate: of a kind that a terminal passes over, a frame or what a later version says.
using SessionMessage = std::variant<std::monostate, SessionStatus, SessionReply, SessionEvent>;

/// Longer ones are refused: the state of a session with a thousand calibrations.
inline constexpr std::size_t kMaxSessionMessageBytes = std::size_t{1} << 22U;

/// Whoever answers at a session's address may send anything: every field that is read is looked at, and no
/// text is made fit for a terminal (one_line() does that). Errors: malformed (no JSON object, a field of its
/// kind missing or of another type), out_of_range (too long; a number that cannot be meant).
[[nodiscard]] Result<SessionMessage> parse_session_message(std::string_view text);

}  // namespace mien::app
