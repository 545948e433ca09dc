#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/face/motion.h"
#include "mien/model/model_file.h"
#include "mien/performer/long_motion.h"
#include "mien/performer/script.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/device_faults.h"

namespace mien::lab {

/// What happens to one face sensor, which is drawn for each person. Minutes after the motion's start.
struct HoursEvent {
  double begin_min = 0;  ///< 0: nothing but what `restarts_min` says.
  double end_min = 0;
  double turn_deg = 0;     ///< It is turned on its skin by so much, about any axis, evenly from begin to end.
  bool silent = false;     ///< Nothing is heard of it from begin to end.
  double heading_deg = 0;  ///< Of a silent one: how far off the heading is that is integrated over the gap.
  double shift_mm = 0;     ///< Of a silent one: it is put on elsewhere, one sigma an axis.
  std::array<double, 2> restarts_min{};  ///< Its board begins anew then; 0: it does not.

  /// When all of it has happened; 0: nothing happens.
  [[nodiscard]] double last_min() const {
    return std::max({begin_min, end_min, restarts_min[0], restarts_min[1]});
  }
};

/// What may go wrong in a session of hours: devices' faults, how the head moves, and what befalls a sensor.
struct HoursScenario {
  std::string_view name;
  std::string_view description;                                           ///< For people: a phrase.
  virt::DeviceFaults (*faults)(const virt::DeviceFaults& rig) = nullptr;  ///< None: those of the rig.
  bool head_still = false;  ///< After the prologue the head does not turn.
  HoursEvent event;
};

/// All of them; "default" first.
[[nodiscard]] std::span<const HoursScenario> hours_scenarios();
/// Errors: not_found, listing the names.
[[nodiscard]] Result<HoursScenario> find_hours_scenario(std::string_view name);

/// Who performs for hours after one calibration, in the rig's *device* profile: every script and motion in
/// every scenario, by everyone.
struct HoursRequest {
  std::vector<performer::Block> scripts;
  std::vector<face::Motion> motions;  ///< Recorded ones, repeated as long as it takes.
  std::optional<face::Face> face;     ///< Everyone's; none: a face of their own.
  std::vector<HoursScenario> scenarios = {hours_scenarios().front()};
  std::uint64_t first_seed = 1;
  std::size_t seeds = 2;  ///< People, 1 or more, each with a style and devices of their own.
  double minutes = 180;   ///< Of each performance after the prologue, above 0.
  std::vector<performer::HeldExpression> held;  ///< Of everyone.
  unsigned threads = 0;                         ///< 0: one a core.
};

/// The live model's squared error of the weights: 53 shapes, both sides clipped to [0, 1].
struct HoursErrors {
  double device = 0;
  double lab = 0;     ///< By true rotations with a degree of noise, which cannot drift.
  double known = 0;   ///< By true rotations without noise: headings and creep known.
  double frozen = 0;  ///< Headings and creep stay as the calibration found them.
};

/// Ten minutes of one performance.
struct HoursPiece {
  double begin_s = 0;
  std::size_t frames = 0;
  HoursErrors mse;
  /// `mse.device` over `mse.lab`, divided by the same of the first piece: 1 is an error that does not grow.
  double ratio = 1;
  double pve_mm = 0, lab_pve_mm = 0;  ///< Vertex error, mean over every twentieth frame.
  std::size_t worst_shape =
      0;                  ///< The shape whose mean error has grown most since the first piece, less *lab*'s.
  double worst_bias = 0;  ///< By how much.
  double rotation_rms_deg = 0;  ///< Error of the face sensors' skin rotations, frame H.
  double vertical_rms_deg = 0;  ///< Its part about the vertical, as headings that are off leave it.
  /// Error of the one sensor to which something happens in the scenario, and the same in *frozen*; 0: none.
  double sensor_rms_deg = 0, frozen_sensor_rms_deg = 0;
  /// That error squared by the covariance that the drift filter states, over its expectation: 1 is a filter
  /// that knows how wrong it is, above 1 one that is too sure.
  double nees = 0;
  double missing = 0;  ///< Share of rotations that were not given, 0 to 1.
  /// Of each expression that is held within this piece: mean weight of its shapes.
  std::vector<HoursErrors> held;
  /// The same in the second that begins ten seconds after the release, of each that is released in this
  /// piece.
  std::vector<HoursErrors> released;
};

struct HoursRun {
  std::string script;    ///< Its name, or the motion's.
  std::string scenario;  ///< Its name.
  std::uint64_t seed = 0;
  std::string sensor;      ///< To which something happens; empty: nothing does.
  double event_end_s = 0;  ///< When all of that has happened.
  std::vector<HoursPiece> pieces;
};

/// Where figures of runs are kept, so that a study that was stopped goes on where it was. A key is text that
/// names all of the request that the run's figures depend on; the rig, the model and the program are the
/// cache's own matter. Called from several threads at once.
struct HoursCache {
  std::function<std::optional<HoursRun>(const std::string& key)> find;
  std::function<Result<void>(const std::string& key, const HoursRun& run)> keep;
};

/// Performs, receives and measures hours of sessions, a second at a time: memory does not grow with their
/// length. The same request gives the same figures on any number of threads. Runs that `cache` has are not
/// performed. Errors: bad_usage (nobody, nothing to perform, no time), mismatch (a model that is not causal),
/// those of the faults, the simulator and the cache; cancelled. Cost: a fortieth of what is performed, on one
/// core.
[[nodiscard]] Result<std::vector<HoursRun>> study_hours(const HoursRequest& request, const sensor::Rig& rig,
                                                        const model::ModelFile& model,
                                                        const Progress& progress,
                                                        const HoursCache* cache = nullptr);

/// Limits of the ratio that the study judges by: for nine runs of ten, and for all.
inline constexpr double kRatioOfMost = 1.3, kRatioOfAll = 1.6;

/// Runs of one kind together: figures of a piece are means over the runs.
struct HoursSummary {
  std::string script, scenario;
  std::size_t runs = 0;
  HoursErrors first_mse, last_mse;  ///< Of the first and of the last ten minutes.
  double worst_ratio = 0;           ///< Largest of any run's pieces.
  double within_most = 0;           ///< Share of the runs all of whose ratios are at most kRatioOfMost.
  double within_all = 0;            ///< The same of kRatioOfAll.
  double first_rotation_deg = 0;
  double worst_rotation_deg = 0;         ///< Largest mean of any ten minutes.
  double least_nees = 0, most_nees = 0;  ///< Range of the means of each ten minutes.
  double first_missing = 0;              ///< Share of rotations, 0 to 1.
  double worst_missing = 0;              ///< Largest of any run's pieces.
  double worst_bias = 0;                 ///< Largest that grew in any run.
  std::size_t worst_shape = 0;           ///< Of that.
  /// Of the sensor to which something happens, ten minutes later, and in *frozen*: root mean square.
  double sensor_deg = 0, frozen_sensor_deg = 0;
};

/// A summary of each script in each scenario, in the order in which they first appear.
[[nodiscard]] std::vector<HoursSummary> summarise(std::span<const HoursRun> runs);

/// Share of the runs whose every piece's ratio is at most `limit`.
[[nodiscard]] double share_within(std::span<const HoursRun> runs, double limit);

}  // namespace mien::lab
