#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lab/columns.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/random.h"
#include "mien/face/face.h"
#include "mien/measure/report.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/imu/device_trouble.h"
#include "mien/virtual/network.h"
#include "mien/virtual/performance.h"

namespace mien::lab {

/// What is made worse: the network, the devices' clocks, or the devices themselves.
enum class Fault : std::uint8_t {
  none,            ///< Nothing beyond the rig's own faults, which are there in every condition.
  loss,            ///< `amount` percent of the packets are lost, each by itself.
  bursts,          ///< The same, ten in a row on average.
  jitter,          ///< Every packet takes some time more, `amount` ms on average (exponential).
  even_jitter,     ///< Every packet takes 0 to `amount` ms more, evenly.
  lag,             ///< Every packet takes `amount` ms more.
  disorder,        ///< `amount` percent come twice, and packets overtake each other by up to 40 ms.
  clock_drift,     ///< Every clock is `amount` ppm off, either way, and stepped by 500 us every ten seconds.
  restart,         ///< One face sensor restarts half-way, with a new clock.
  shared_id,       ///< One face sensor sends with another's id; the first of the two is received.
  sensor_silent,   ///< The face sensor `sensor` is never heard.
  sensors_silent,  ///< `amount` face sensors are never heard.
  head_silent,     ///< The head's sensor is not heard for `amount` seconds, half-way.
  corrupted,       ///< `amount` percent of the packets have one to four bytes changed.
  truncated,       ///< Of `amount` percent only a beginning arrives.
  frozen,          ///< `amount` face sensors say the same from the motion's beginning to its end.
  all_silent,      ///< Nothing is heard for `amount` seconds, half-way.
};

/// One setting that performances are heard under. Sensors that are not named are drawn for each performance.
struct LossCondition {
  Fault fault = Fault::none;
  double amount = 0;
  std::string sensor;  ///< Of Fault::sensor_silent.

  /// As a table's row has it.
  [[nodiscard]] std::string name() const;
};

/// The study's own conditions for a rig, in the order in which they are shown: loss and bursts to 20 %,
/// jitter and lag to 100 ms, disorder, clocks, a restart, two nodes with one id, every face sensor silent,
/// two and three at once, the head's for two seconds. Without Fault::none, and without what the rig has too
/// few sensors for.
[[nodiscard]] std::vector<LossCondition> loss_conditions(const sensor::Rig& rig);

/// What a condition asks of the network and the devices.
struct Impairment {
  virt::NetworkSettings network;
  virt::DeviceTroubles troubles;
};

/// The condition's impairment of one performance, whose motion lasts from `begin_s` to `end_s` of the
/// session. Sensors and clocks that it does not name are drawn from `random`; three that fall silent are the
/// two and one more. Errors: not_found (a sensor; too few of them).
[[nodiscard]] Result<Impairment> impairment(const LossCondition& condition, const sensor::Rig& rig,
                                            double begin_s, double end_s, const Random& random);

/// Who performs: virtual performers of the built-in family, whom no training has (their random streams are
/// the study's own), or given motions; after a brief prologue, in the rig's *device* profile.
struct LossRequest {
  int performers = 12;  ///< 1 or more; 0 is 1. Passed over where motions are given.
  double seconds = 60;  ///< Of each virtual performance after the prologue, above 0.
  std::vector<virt::GivenMotion> motions;
  std::vector<face::Face> faces;
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// How well the model did under one condition, over the evaluated frames of all performances.
struct LossRow {
  LossCondition condition;
  std::size_t frames = 0;
  double mse = 0;  ///< As measure::Metrics has these three; each performance on its own face.
  double mse_observed = 0;
  double pve_mm = 0;
  double rise = 0;  ///< mse over that of Fault::none, less one.
  /// Share gone of what the model knows, which is by how much it beats the mean pose with Fault::none: 0 is
  /// as good as there, 1 as good as knowing nothing; may be more or less. 0 where it knows nothing there.
  double given_up = 0;
  double observed = 0;  ///< Share of the face sensors' rotations that the model was given.
  /// How far the rotations that were given lie from the truth, in the head frame, degrees, RMS: what the
  /// condition does to the sensing, whatever the model makes of it.
  double rotation_rms_deg = 0;
  /// Largest change of any weight from one frame to the next, of what a session shows of the answer
  /// (shaping::Shaper, without settings of a user) and of the truth.
  double largest_step = 0;
  double truth_step = 0;
  std::size_t unsound = 0;  ///< Frames with a weight that is not finite or outside [0, 1]; of all frames.
  /// Frames that say "measured" of any shape where no sensor had a rotation; of all frames. How true it is
  /// where some had: study_confidence().
  std::size_t mistold = 0;
  std::vector<double> performance_mse;  ///< Of each, in their order.
};

/// What is promised of the live model.
inline constexpr double kRiseAllowedAt10Percent = 0.25;
inline constexpr double kRiseAllowedWithoutASensor = 0.30;

struct LossStudy {
  std::vector<LossRow> rows;  ///< Fault::none first, then as the conditions were given.
  double mean_pose_mse = 0;   ///< Of the training set's mean pose on the first row's frames: knowing nothing.

  /// The first row under these; nullptr where there is none.
  [[nodiscard]] const LossRow* find(Fault fault, double amount) const;
  /// Of the rows with one face sensor silent, that with the largest rise; nullptr where there is none.
  [[nodiscard]] const LossRow* worst_sensor() const;
  /// Of all rows.
  [[nodiscard]] std::size_t unsound() const;
  [[nodiscard]] std::size_t mistold() const;
  /// Whether every promise that its rows can tell of is kept.
  [[nodiscard]] bool kept() const;
};

/// Every performance under every condition, through impair, the IMU pipeline with the prologue's marks,
/// and the live tracker. Each condition meets the same performances, devices and network's draws; the result
/// does not depend on the number of threads. Errors: mismatch (a model that is no live one, or of other
/// sensors), not_found (a condition's sensor; no frame to measure), bad_usage (a motion without frames, or of
/// no face), those of the faults and of impair; cancelled. Cost: about a second of one core a minute
/// of performance and condition.
[[nodiscard]] Result<LossStudy> study_loss(const LossRequest& request, const sensor::Rig& rig,
                                           const model::ModelFile& model,
                                           const std::vector<LossCondition>& conditions,
                                           const Progress& progress);

/// The figures of a condition.
[[nodiscard]] const Columns<LossRow>& loss_columns();

/// The study as people read it: what is promised and what came out, the curve of accuracy against loss, every
/// condition, and every sensor. `subtitle` says who performed and which model answered.
[[nodiscard]] measure::Report loss_report(const LossStudy& study, const std::string& subtitle);

}  // namespace mien::lab
