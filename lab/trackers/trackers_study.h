#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lab/trackers/compare_curves.h"
#include "lab/trackers/modelled_tracker.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/measure/metrics.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"

// What is shown of comparisons of trackers, whether of recordings or of virtual performers.
namespace mien::lab {

/// What is measured of a tracker (docs/reference/tracker_curves.md, "Errors").
enum class TrackerMeasure : std::uint8_t {
  pve_seen,         ///< mm, over the frames that it saw, its lag in it.
  pve_without_lag,  ///< The same moved by its lag.
  pve_held,         ///< mm, over all frames, the last face held in gaps.
  pve_whole,        ///< The same with 0 for what is not told.
  pve_face_held,
  landmarks_held,
  mse_seen,  ///< Over told shapes, as pve_seen.
  mse_without_lag,
  mse_held,
  mse_common,  ///< As mse_held, over the shapes that all tell.
  mse_whole,   ///< As mse_held, over all 53.
  gap_share,
  lag,        ///< ms, positive: late.
  lag_sigma,  ///< ms.
};
inline constexpr std::size_t kTrackerMeasureCount = 14;
/// "pve_seen_mm", "gap_share", "lag_ms", ...: as `mien study trackers --json` has them.
[[nodiscard]] std::string_view tracker_measure_name(TrackerMeasure measure);
/// Of one tracker and one performance; nothing where it cannot be told.
using TrackerFigures = std::array<std::optional<double>, kTrackerMeasureCount>;
/// Errors over all frames are left out where they have an unknown offset in them.
[[nodiscard]] TrackerFigures figures_of(const CurveScore& score);

/// A mean over performers and its 95 % interval.
struct TrackerMean {
  double mean = 0;
  std::size_t performers = 0;  ///< That have it.
  /// Student's t over performers (mean_interval); absent with fewer than two of them.
  std::optional<std::array<double, 2>> interval;
};
/// Nothing where there is no value.
[[nodiscard]] std::optional<TrackerMean> mean_over_performers(const std::vector<double>& values);

/// One tracker under one condition.
struct TrackerMethod {
  std::string name;
  std::size_t told = 0;                    ///< Shapes.
  std::vector<TrackerFigures> performers;  ///< In their order.

  /// Over the performers that have it.
  [[nodiscard]] std::optional<TrackerMean> over(TrackerMeasure measure) const;
  /// By how much it is above `other`, over the performers where both have it.
  [[nodiscard]] std::optional<TrackerMean> above(const TrackerMethod& other, TrackerMeasure measure) const;
};

/// A few seconds around the moment at which trackers do worst.
struct TrackerMoment {
  struct Line {
    std::string name;
    ToldShapes told;
    std::vector<face::BlendshapeWeights> shown;  ///< One a time.
    std::vector<bool> saw;
  };
  std::size_t performer = 0;
  double worst_s = 0;   ///< Its middle, on the truth's time.
  double pve_mm = 0;    ///< Of the worst tracker over that second.
  double above_mm = 0;  ///< By how much that lies above the reference's over the same second.
  std::string worst;    ///< Which that is; empty where there is none.
  std::vector<double> time_s;
  std::vector<face::BlendshapeWeights> truth;
  std::vector<Line> lines;
};
/// The second in which the error of what is shown lies highest above that of the tracker called `reference`;
/// above zero where there is none of that name. Two and a half seconds each way are kept. Trackers of unknown
/// offset are never the worst; where there are no others the moment is empty.
[[nodiscard]] TrackerMoment worst_moment(const CurveComparison& comparison, std::string_view reference);

/// All trackers under one condition, on the same performances.
struct TrackersRow {
  std::string key;         ///< "talking"; of recordings "recording".
  std::string title;       ///< For people.
  std::string what;        ///< What is the matter with it, a sentence; may be empty.
  std::size_t frames = 0;  ///< Of all performers.
  double frames_hz = 60;   ///< How many a second.
  std::size_t common = 0;  ///< Shapes that all tell.
  std::vector<TrackerMethod> methods;
  std::optional<TrackerMoment> moment;

  /// nullptr where there is none of that name.
  [[nodiscard]] const TrackerMethod* find(std::string_view method) const;
  /// Keeps of its moments that which lies furthest above the reference; an empty one is none.
  void keep_worst(TrackerMoment other);
};

struct TrackersStudy {
  std::vector<TrackersRow> rows;
  /// The one that the others are held against; empty: none.
  std::string reference;
  bool modelled = false;     ///< Camera trackers are models, not recordings.
  bool shared_clock = true;  ///< Else the offsets that were found are taken out (CompareSettings).
  std::vector<std::string> offset_unknown;  ///< Recordings of which none was found.
};

/// A comparison of recordings as a study of one row and one performer.
[[nodiscard]] TrackersStudy study_of(const CurveComparison& comparison, std::string title);

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
