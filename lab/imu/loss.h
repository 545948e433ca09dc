#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "lab/columns.h"
#include "lab/imu/loss_condition.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/face/face.h"
#include "mien/measure/report.h"
#include "mien/model/model_file.h"
#include "mien/sensor/rig.h"
#include "mien/virtual/performance.h"

namespace mien::lab {

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

/// Every performance under every condition, through virt::impair, the IMU pipeline with the prologue's marks,
/// and the live tracker. Each condition meets the same performances, devices and network's draws; the result
/// does not depend on the number of threads. Errors: mismatch (a model that is no live one, or of other
/// sensors), not_found (a condition's sensor; no frame to measure), bad_usage (a motion without frames, or of
/// no face), those of the faults and of virt::impair; cancelled. Cost: about a second of one core a minute
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
