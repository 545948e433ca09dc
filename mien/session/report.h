#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mien/core/time.h"
#include "mien/face/profile.h"
#include "mien/sensor/calibration.h"
#include "mien/sensor/link_health.h"
#include "mien/sensor/picture_view.h"
#include "mien/session/prompt.h"
#include "mien/tracker/tracker.h"

namespace mien::session {

/// One of a session's calibrations.
struct CalibrationVersion {
  std::int64_t id = 0;
  DeviceTime made;
  std::string origin;   ///< "self", "guided", "recentre", "restored", "phone".
  std::string json;     ///< The tracker's.
  std::string centre;   ///< The shaper's re-centring, JSON.
  std::string resting;  ///< The resting face that the shaper had learnt, JSON.
  std::vector<sensor::Score> scores;
};

/// How a session is, for people: what `status` messages carry (docs/reference/page_protocol.md).
struct Report {
  /// Somebody who sends as a sensor's device, and is not accepted as it.
  struct Rival {
    std::string source;        ///< As the log names it: "udp://192.168.1.7:5005".
    Duration age{};            ///< Since its newest reading.
    bool implausible = false;  ///< As sensor::Plausibility has it.
  };
  struct Link {
    std::string device;         ///< Empty while unbound.
    std::string source;         ///< Where the readings that are taken come from; empty while none came.
    std::vector<Rival> rivals;  ///< Of the last ten seconds, at most four.
    sensor::LinkReport health;
    std::optional<double> heading_sigma_rad;
    std::optional<tracker::SensorCertainty> certainty;
    std::optional<double> level;              ///< As sensor::level() has it, of the newest sample.
    std::optional<sensor::PictureView> view;  ///< Of a camera.
  };
  struct Unbound {
    std::string device;
    std::string announces;
    std::string protocol;
    Duration age{};
    std::string source;  ///< Where it sends from.
  };
  /// Datagrams of a version that this program does not know.
  struct UnknownVersion {
    std::string protocol;  ///< As sensor::Protocol::name().
    unsigned version = 0;
    std::string source;  ///< Who sent the first.
    std::uint64_t count = 0;
  };
  struct Calibration {
    std::string state;  ///< "watching", "running", "done", "failed".
    std::string step;
    std::string prompt;
    std::optional<face::BlendshapeWeights> target;
    /// Where to look, as face::GazeTarget has it, rad; none while that is no matter.
    std::optional<Eigen::Vector2f> look_rad;
    std::size_t step_number = 0;  ///< From 1; 0 when none runs.
    std::size_t steps = 0;
    double progress = 0;  ///< Of the step, 0 to 1.
    double remaining_s = 0;
    std::int64_t in_force = 0;
    /// Since the calibration in force was made, s, and since the re-centring after it; none without one.
    std::optional<double> age_s, recentred_s;
    /// How well the sensors' rotations are known: standard deviation of the angle's error, RMS over the
    /// sensors that are there, rad; none where nothing drifts.
    std::optional<double> sigma_rad;
    bool advises_recentring = false;           ///< It would gain (DriftWatch).
    std::uint64_t faults = 0;                  ///< As tracker::Tracker::faults().
    std::vector<CalibrationVersion> versions;  ///< Without their JSON.
  };

  /// The poses and lines that are asked for, of a recording with prompts.
  struct Prompts {
    std::string state;              ///< "none", "ready", "running", "paused", "over", "block".
    Prompt prompt;                  ///< The present one, or the first to come.
    Prompt next;                    ///< After it; without a name when there is none.
    std::vector<std::string> poor;  ///< What was with the line that was over last, a sentence each.
    std::size_t again = 0;          ///< How many of those to come are asked for again.
    std::size_t number = 0;         ///< From 1.
    std::size_t of = 0;
    double progress = 0;     ///< Of the present one, 0 to 1.
    double remaining_s = 0;  ///< Of the present one; when ready, until it begins.
    double left_s = 0;       ///< Until all are over.
  };

  DeviceTime time;
  std::uint64_t frames = 0;
  std::vector<Link> links;  ///< One a sensor of the rig.
  std::vector<Unbound> unbound;
  Calibration calibration;
  Prompts prompts;
  std::string shaping;  ///< JSON: {"smoothing", "gains", "limits"}.
  std::string resting;  ///< The resting face in force at the newest frame, JSON.
  std::string tap;      ///< The sensor that waits for a tap; empty: none.
  /// Binding by covering a lens.
  struct Cover {
    std::string sensor;   ///< The one that waits for it; empty: none.
    std::string trouble;  ///< Why the last wait ended without a camera; empty: it did not.
  };
  Cover cover;
  /// What is heard; none where the rig has no microphone.
  struct Hearing {
    bool on = true;       ///< MergeSettings::audio.
    bool speaks = false;  ///< Somebody does.
    double share = 0;     ///< Of the frames so far, those of which a shape is from sound.
    Duration later{};     ///< As tracker::TickResult has it.
  };
  std::optional<Hearing> hearing;
  std::uint64_t malformed = 0;
  std::uint64_t refused = 0;
  std::vector<UnknownVersion> unknown_versions;  ///< The first that came, at most eight.
  /// By how much frames are held back for packets that come late, which adds to every frame's latency; now,
  /// and at most so far.
  Duration hold{};
  Duration longest_hold{};
};

}  // namespace mien::session
