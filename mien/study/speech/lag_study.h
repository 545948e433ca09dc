#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/study/speech/mouth_score.h"
#include "mien/study/speech/speaker.h"
#include "mien/study/speech/spoken_session.h"

namespace mien::study {

/// For so long somebody reads, or for a line more.
inline constexpr double kLagReading_s = 110;
/// Whether all sensors are lost at a time of the reading, s: for 2 s of every 8, in its last 50 s, so that a
/// lag can be found before.
[[nodiscard]] bool is_lost_in_reading(double reading_s);

struct LagRequest {
  int people = 3;      ///< Seeds from `seed` on: another person, voice and reading each.
  double by_s = 0.12;  ///< How early and how late sound is.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// How a lag was followed over a reading.
struct LagFollowed {
  std::optional<double> believed_s;  ///< When one was believed first, s; none: never.
  double believed_share = 0;         ///< Share of the frames, from the reading's begin to its end.
  double offset_s = 0;               ///< At the end.
};
/// Of frames at kFrameRateHz from the reading's begin on; equal sizes.
[[nodiscard]] LagFollowed follow_lag(const std::vector<bool>& believed, std::span<const Duration> offset);

/// Sound with one lag.
struct LagRow {
  double lag_s = 0;  ///< By which sound is late; below 0: early.
  LagFollowed followed;
  /// While sensors are lost, without the first 0.3 s, in which mouth and jaw change hands: without a
  /// microphone, with its sound as it comes, and with sound that is retimed.
  MouthScore held, heard, retimed;
};
struct LagPerson {
  std::uint64_t seed = 0;
  std::string voice;
  std::vector<LagRow> rows;  ///< Early, on time, late.
};

/// Lets people read to sensors that are lost now and then and a microphone whose sound is early, on time and
/// late: how the lag is found, and what retiming is worth. The retiming is a session's own
/// (shaping::CombinedTracker's). Voices are those for tests, sound is clean. Errors: check_scene()'s; the
/// speaker's, the devices', the model's; cancelled.
[[nodiscard]] Result<std::vector<LagPerson>> study_lag(const LagRequest& request, const SpokenScene& scene,
                                                       const Speaker& speaker, const Progress& progress);

}  // namespace mien::study
