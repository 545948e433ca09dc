#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/random.h"
#include "mien/core/time.h"
#include "mien/face/motion.h"
#include "mien/headset/headset_model.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/headset/headset_film.h"
#include "mien/tracker/tracker.h"

namespace mien::lab {

/// What a network finds in a film's views, and what is true of them.
struct SeenFilm {
  std::vector<synthetic::FilmTruth> truth;
  /// headset::FeatureRecord, of each frame and camera.
  std::vector<std::vector<std::vector<std::byte>>> records;
};
/// `frames`: views of the network's size, one of each of the rig's sensors, in its order. Errors: those of
/// headset_cameras(); internal (features that no record takes).
[[nodiscard]] Result<SeenFilm> look_at(const std::vector<synthetic::FilmFrame>& frames,
                                       const sensor::Rig& rig, const headset::HeadsetModel& model);

/// Which cameras' pictures of a film's frame arrive; empty: all.
using CameraArrives = std::function<bool(std::size_t camera)>;
/// Hands the records of one frame, exposed at `now`, to a tracker, on one clock.
void deliver(const std::vector<std::vector<std::byte>>& records, DeviceTime now, const sensor::Rig& rig,
             const CameraArrives& arrives, sensor::TimeLines& lines, tracker::Tracker& tracker);

/// A wearer who looks at the targets of a calibration of gaze, one after the other, as a virtual performer
/// does (performer::look_at_targets): kTaughtGaze_s, at 60 Hz from 0 on.
inline constexpr double kTaughtGaze_s = 7.5;
[[nodiscard]] face::Motion gaze_targets_motion(const Random& random);
/// Tells a tracker that they are looked at from `begin` on.
void guide_gaze_targets(DeviceTime begin, tracker::Tracker& tracker);

}  // namespace mien::lab
