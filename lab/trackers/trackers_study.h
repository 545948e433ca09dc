#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "lab/trackers/modelled_tracker.h"
#include "lab/trackers/tracker_figures.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/measure/metrics.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"

namespace mien::lab {

/// What befalls the same people, in the order of the table. The sensors are in the profile *device*
/// throughout.
enum class TrackerCondition : std::uint8_t {
  talking,      ///< Reads, before the camera.
  hand,         ///< The same with a hand before the mouth now and then; no sensor is touched.
  turned_away,  ///< The same, the head turned by 45 to 80 degrees half of the time.
  dark,         ///< The same as talking, without light.
  walking,      ///< The same, walking throughout; the camera is held in the hand.
  eating,       ///< A meal: hand and cup before the mouth.
  rapid,        ///< Rapid faces, and a head that darts.
};
inline constexpr std::size_t kTrackerConditionCount = 7;
/// "talking", "turned_away", ...
[[nodiscard]] std::string_view tracker_condition_name(TrackerCondition condition);
/// Errors: not_found, with the nearest name and those that there are.
[[nodiscard]] Result<TrackerCondition> parse_tracker_condition(std::string_view name);

/// What our own curves are called.
inline constexpr std::string_view kOwnCurves = "Mien (IMUs)";

struct TrackersRequest {
  std::vector<TrackerCondition> conditions;  ///< Empty: all.
  int performers = 6;   ///< Virtual ones of the built-in family (the streams are the study's own).
  double seconds = 30;  ///< Of each performance after the prologue, at least 3.
  CompareSettings compare;
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// The motion with a head that turns away from where it looked, to 45 to 80 degrees aside for two to four
/// seconds, and back for two to three, again and again.
[[nodiscard]] face::Motion with_head_turned_away(face::Motion motion, Random random);

/// A live model from IMUs beside the modelled camera trackers, on the same virtual performances: for each
/// condition devices, prologue and IMU pipeline as `mien study live` has them, the model frame by frame, each
/// tracker by model_tracker(), and all by compare_curves() on the truth's ticks after the prologue. Where a
/// condition changes nothing that a sensor feels (hand, dark), our curves are those of `talking`: that
/// follows from how they are made, and is no finding. The result depends neither on the number of threads nor
/// on which other conditions are studied.
///
/// Errors: bad_usage (nobody performs, too short), mismatch (a model of other sensors, or that is not
/// causal), those of the faults and devices; cancelled.
[[nodiscard]] Result<TrackersStudy> study_trackers(const TrackersRequest& request, const sensor::Rig& rig,
                                                   const model::ModelFile& model, const Progress& progress);

}  // namespace mien::lab
