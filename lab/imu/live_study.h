#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/measure/metrics.h"
#include "mien/measure/report.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/tracker/window_solver.h"
#include "mien/virtual/imu/device_faults.h"
#include "mien/virtual/performance.h"

namespace mien::lab {

/// What the same people meet, in the order of the table. All but the first in the profile *device*.
enum class LiveCondition : std::uint8_t {
  lab,              ///< The profile *lab*: true rotations with a degree of noise.
  seen,             ///< Sensors where they belong, but for the rig's own placement error, which training had.
  unseen,           ///< 5 mm off an axis, on skin that lies 10 degrees another way.
  remount,          ///< As seen, worn anew: other placement, mounting and faults, calibrated anew.
  walking,          ///< As seen, walking throughout.
  running,          ///< As seen, running throughout.
  eating,           ///< A meal instead of the script; virtual performers alone.
  rapid,            ///< Rapid faces and darting heads instead of the script; of given motions the head alone.
  one_lost,         ///< As seen, one face sensor never heard.
  three_lost,       ///< As seen, three never heard.
  bursts,           ///< As seen, a tenth of the packets lost, ten in a row on average.
  other_simulator,  ///< Skin, noise, slip and lag of other distributions than the training's.
  long_session,     ///< The same minute ten times over: its first time, and its last.
};
inline constexpr std::size_t kLiveConditionCount = 13;

/// What conditions are called; those of one group follow each other and are drawn together.
struct LiveConditionNames {
  std::string_view name;  ///< "seen", "other_simulator", ...: as --rows and JSON have it.
  std::string_view title, group;
};
/// By LiveCondition.
inline constexpr std::array<LiveConditionNames, kLiveConditionCount> kLiveConditions = {
    {{"lab", "lab profile", "Where the sensors are"},
     {"seen", "seen placement", "Where the sensors are"},
     {"unseen", "5 mm, 10° off", "Where the sensors are"},
     {"remount", "re-mounted", "Where the sensors are"},
     {"walking", "walking", "What the wearer does"},
     {"running", "running", "What the wearer does"},
     {"eating", "eating", "What the wearer does"},
     {"rapid", "rapid motion", "What the wearer does"},
     {"one_lost", "one sensor lost", "What is lost"},
     {"three_lost", "three lost", "What is lost"},
     {"bursts", "10 % lost in bursts", "What is lost"},
     {"other_simulator", "another simulator", "Another simulator"},
     {"long_session", "long session", "A long session"}}};
[[nodiscard]] inline const LiveConditionNames& names_of(LiveCondition condition) {
  return kLiveConditions[static_cast<std::size_t>(condition)];
}
/// Errors: not_found, with the names that there are.
[[nodiscard]] Result<LiveCondition> parse_live_condition(std::string_view name);
/// All that the rig has sensors enough for.
[[nodiscard]] std::vector<LiveCondition> live_conditions(const sensor::Rig& rig);

/// What is measured of an estimate (docs/reference/metrics.md).
enum class Measure : std::uint8_t { pve, pve_face, landmarks, mse, mse_observed, jitter, blinks };
inline constexpr std::size_t kMeasureCount = 7;
struct MeasureNames {
  std::string_view name;  ///< As `mien evaluate --json` has it.
  std::string_view head;  ///< In tables.
  int decimals;
};
/// By Measure.
inline constexpr std::array<MeasureNames, kMeasureCount> kMeasures = {{{"pve_mm", "PVE, mm", 3},
                                                                       {"pve_face_mm", "PVE face, mm", 3},
                                                                       {"lmk_mm", "landmarks, mm", 3},
                                                                       {"mse", "MSE", 4},
                                                                       {"mse_observed", "MSE of 42", 4},
                                                                       {"jitter_ratio", "jitter", 2},
                                                                       {"blink_f1", "blink F1", 2}}};
/// Of one estimate of one performance; nothing where the data or the method lack it.
using Figures = std::array<std::optional<double>, kMeasureCount>;

/// One way to tell the weights, under one condition.
struct LiveMethod {
  std::string name;
  std::vector<Figures> performers;  ///< In their order.

  /// Mean and standard deviation over the performers that have it (n - 1; 0 of one); nothing where none has.
  [[nodiscard]] std::optional<measure::MeanStd> over(Measure measure) const;
};

/// All methods under one condition, on the same performances.
struct LiveRow {
  LiveCondition condition = LiveCondition::seen;
  std::string title;
  std::size_t frames = 0;  ///< Of all performers.
  double observed = 0;     ///< Share of the face sensors' rotations that were given.
  /// How far these lie from the truth, in the head frame, degrees, RMS.
  double rotation_rms_deg = 0;
  std::vector<LiveMethod> methods;

  /// nullptr where there is none of that name.
  [[nodiscard]] const LiveMethod* find(std::string_view method) const;
};

/// Rows of the same people.
struct LiveSet {
  std::string who;
  std::vector<LiveRow> rows;
};

struct LiveStudy {
  std::vector<LiveSet> sets;  ///< Virtual performers, then given motions.
};

/// What is compared. The baselines (ridge, mean pose) are those of the first causal model.
struct LiveModels {
  struct Causal {
    std::string name;
    model::ModelFile file;
  };
  std::vector<Causal> causal;  ///< At least one.
  const tracker::WindowSolver* window = nullptr;
  std::vector<std::size_t>
      window_steps;  ///< Denoising steps that the window network is asked with, a method each.
};

/// Names of the methods that are no model.
inline constexpr std::string_view kRidge = "ridge", kHoldLast = "hold last", kMeanPose = "mean pose",
                                  kSensorBound = "sensor bound";

struct LiveRequest {
  std::vector<LiveCondition> conditions;  ///< Empty: live_conditions().
  int performers =
      4;  ///< Virtual ones of the built-in family, whom no training has (the streams are the study's own).
  double seconds = 30;  ///< Of each virtual performance after the prologue, above 0.
  std::vector<virt::GivenMotion> motions;
  std::vector<face::Face> faces;
  std::string motions_are;   ///< Of the given motions' rows, for people.
  double given_seconds = 0;  ///< Of each given motion, from its beginning; 0: all.
  /// The long session: this many times the first `round_s` of a performance, with a second to come back.
  int rounds = 10;
  double round_s = 60;
  virt::DeviceFaults other_faults;  ///< Of other_simulator.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// Every method on every performance under every condition: virtual devices, prologue, IMU pipeline, and then
/// what `mien evaluate` measures, a performer at a time. The sensor bound (sensor_bound.h) is that of the
/// performer's own sites, without those that are mostly missing, for the noise that the rotations were found
/// to have and a prior as wide as the performer's weights are around the mean pose. The result does not
/// depend on the number of threads, nor one condition's on which others are studied.
///
/// Errors: bad_usage (no causal model, nobody to perform, a motion without a face or frames), mismatch (a
/// model of other sensors, or that is not causal), not_found (too few sensors for a condition), those of the
/// faults; cancelled.
[[nodiscard]] Result<LiveStudy> study_live(const LiveRequest& request, const sensor::Rig& rig,
                                           const LiveModels& models, const Progress& progress);

/// A set's rows as one table: each condition a strong row that says how well was sensed, then its methods,
/// each figure as mean ± standard deviation over performers.
[[nodiscard]] measure::Table live_table(const LiveSet& set);

/// The whole study on one page: for each set its figures, a plot of the vertex error for each group of
/// conditions, and the table.
[[nodiscard]] measure::Report live_report(const LiveStudy& study, const std::string& subtitle);

}  // namespace mien::lab
