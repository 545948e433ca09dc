#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/time.h"
#include "mien/face/gaze_targets.h"
#include "mien/model/correction.h"
#include "mien/sensor/picture_view.h"
#include "mien/sensor/protocol.h"
#include "mien/session/consent.h"
#include "mien/session/prompt.h"
#include "mien/tracker/tracker.h"

namespace mien::session {

// What a person may ask of a session while it runs: those commands of docs/reference/page_protocol.md that
// change weights or a take's events. They go into the session log as they came, and a replay obeys them
// again.

struct Calibrate {
  enum class Kind : std::uint8_t {
    brief,   ///< "short": neutral, nod and shake, as the sensors need them.
    full,    ///< "full": then the anchor expressions.
    wearer,  ///< "wearer": then a range of motion as well, and the wearer is learnt from all of them.
    gaze,    ///< "gaze": as brief, then targets to look at.
  };
  Kind kind = Kind::brief;
  /// A step whose time is known beforehand, as a virtual performer's is: the frames [begin, end) of the
  /// output grid. Of `step`, `range` and `look` one is set.
  struct GivenStep {
    tracker::Step step = tracker::Step::none;
    bool range = false;                      ///< A range of motion.
    const face::GazeTarget* look = nullptr;  ///< The eyes rest on this target.
    DeviceTime begin, end;
  };
  /// At most kMostSteps, ascending by `begin`, all in the future. With steps the session leads nobody: it
  /// follows them, and `kind` has no meaning.
  std::vector<GivenStep> steps;
  static constexpr std::size_t kMostSteps = 1024;
};
struct CancelCalibration {};
/// Puts a version in force that the session made before.
struct UseCalibration {
  std::int64_t version = 0;
};
/// Puts a calibration in force that came from elsewhere: its JSON.
struct RestoreCalibration {
  std::string json;
};
struct Recentre {};
struct Bind {
  std::string sensor;  ///< Of the rig.
  sensor::DeviceKey device;
};
/// Of those who send as a sensor's device this one is accepted.
struct Hear {
  std::string sensor;  ///< Of the rig.
  std::string source;  ///< As the log names it: "udp://192.168.1.7:5005".
};
/// The next device that is tapped is bound to this sensor; empty: none any more.
struct Tap {
  std::string sensor;
};
/// The next camera whose lens is covered is bound to this sensor; empty: none any more.
struct Cover {
  std::string sensor;
};
/// Which part of this camera's pictures the network sees, and how it is turned.
struct View {
  std::string sensor;  ///< Of the rig.
  sensor::PictureViewChange change;
};
/// Shaping settings, each optional, as JSON: {"smoothing", "gains", "limits", "merge"}.
struct Shape {
  std::string json;
};

/// One more pose to ask the performer for, after those before.
struct AddPrompt {
  Prompt prompt;
};
/// What becomes of the poses and lines that are asked for.
struct Prompting {
  enum class Do : std::uint8_t {
    skip,
    pause,
    resume,
    stop,
    begin,  ///< The block that waits.
    next,   ///< What is shown at the performer's own pace was performed.
    again,  ///< What is shown from its beginning, or the one before.
    voice,  ///< Texts are over when they were spoken, from now on, ...
    key,    ///< ... or only by `next`.
  };
  Do what = Do::skip;
};

/// Answers are corrected for the wearer by this from now on: what a phone taught.
struct Correct {
  model::Correction correction;
};

/// The performer agrees to be recorded for a dataset. Without it no line of a block is asked for.
struct GiveConsent {
  Consent consent;
};

/// What was agreed to is over: what comes is no dataset's.
struct EndConsent {};

using Command =
    std::variant<Calibrate, CancelCalibration, UseCalibration, RestoreCalibration, Recentre, Bind, Hear, Tap,
                 Cover, View, Shape, AddPrompt, Prompting, GiveConsent, EndConsent, Correct>;

/// Where commands come from, in a session log.
inline constexpr std::string_view kPageSource = "page";
/// Longer ones are refused.
inline constexpr std::size_t kMaxCommandBytes = std::size_t{1} << 17U;

/// Whether a command of this name is the session's; others are the page's own business.
[[nodiscard]] bool is_session_command(std::string_view name);

/// From JSON, {"command": NAME, ...}. Errors: malformed, out_of_range (too long), unsupported (another name).
[[nodiscard]] Result<Command> parse_command(std::string_view json);
/// JSON that parse_command takes back.
[[nodiscard]] std::string write_command(const Command& command);

}  // namespace mien::session
