#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>

#include "mien/core/time.h"
#include "mien/imu/calibration.h"
#include "mien/imu/drift_filter.h"
#include "mien/imu/fusion.h"
#include "mien/imu/nod_watch.h"
#include "mien/imu/rest_measurement.h"
#include "mien/imu/self_calibration.h"
#include "mien/model/features.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"
#include "mien/tracker/tracker.h"

namespace mien::imu {

/// Settings of the pipeline. Defaults: docs/method/fusion.md, "Settings of the pipeline".
struct PipelineSettings {
  FusionSettings fusion;
  DriftSettings drift;
  NodSettings nod;
  RestSettings rest;
  /// Fuse the magnetometer where samples carry one. True: all headings are magnetic, Z_i is the identity, and
  /// no heading is tracked. False: headings are relative, from nods (a magnetometer near electronics is off
  /// by 5 deg).
  bool magnetometer = false;
  /// Track heading drift after the calibration (DriftFilter). False: headings stay as the calibration
  /// found them, and no sensor is left out for its uncertainty.
  bool track_heading = true;
  /// Gating by uncertainty (no hysteresis): a sensor is missing while the standard deviation of its rotation,
  /// heading (DriftFilter) and tilt (after gaps) together as a root sum of squares, is above this, rad (17
  /// deg). A wrong rotation costs a face more than none. Applies while headings are tracked. Raising:
  /// uncertain sensors stay, more rotations, some of them wrong. Lowering: more sensors are missing. Must
  /// stay above the 15 deg that a self-calibration accepts, or its sensors are missing from the start.
  double unsure_rad = 0.3;
  /// Self-calibration: while there is no calibration, detect a still face, a nod and a shake, and calibrate
  /// by them (docs/method/calibration.md). Live sessions set it (ImuTracker::live_settings()).
  bool calibrates_itself = false;
  /// Time-out: a sensor whose newest sample is older than this at a frame is missing (150 ms). Raising:
  /// drop-outs hide behind held values. Lowering: sensors are missing sooner. Chosen, as `bridge`, on virtual
  /// people of the studies of settings (docs/experiments/loss.md).
  Duration silence = std::chrono::milliseconds(150);
  /// Time-out of the ear sensor, without which nothing is known against the head: beyond `silence` its
  /// orientation is bridged by the head's turn as the face sensors felt it (250 ms; at most what their tracks
  /// hold, a quarter of a second at 240 Hz). Raising: longer gaps leave rotations, whose error is skin that
  /// turned together. Lowering: all rotations are missing sooner; at most `silence`: nothing is bridged.
  Duration bridge = std::chrono::milliseconds(250);
  /// The same for a board without device time that sends only changes of its rotation (1 s). Raising and
  /// lowering: likewise.
  Duration unchanged = std::chrono::seconds(1);
  /// Longest extrapolation by the last rate where the frame is later than the newest sample; held beyond it
  /// (25 ms). Raising: less lag behind late samples, more overshoot. Lowering: values are held sooner.
  Duration prediction = std::chrono::milliseconds(25);
};

/// Uncertainty and packet losses of one sensor. Headings are 0 for the ear sensor and with a magnetometer.
struct SensorStatus {
  double heading_rad = 0;        ///< Z_i now, (-pi, pi].
  double heading_sigma_rad = 0;  ///< Its standard deviation; grows without measurements.
  double tilt_sigma_rad = 0;     ///< Of its tilt after gaps, until gravity has corrected it.
  /// Covariance of the error that heading and creep leave in E_i, frame H, rad^2; zero for the ear sensor.
  Mat3 drift_rad2 = Mat3::Zero();
  bool present = false;       ///< A calibrated face sensor that had a rotation at the last tick, ...
  bool left_out = false;      ///< ... which was not given, since it is too uncertain (unsure_rad).
  std::uint64_t dropped = 0;  ///< Samples that arrived twice, or too late to be put in their place.
  std::uint64_t lost = 0;     ///< Samples that never arrived, by gaps in device time.
  /// How often the drift filter had to begin anew for a covariance that was none: a defect of this program.
  std::uint64_t faults = 0;
};

/// From decoded IMU samples to features: fusion, calibration, removal of the head's rotation, head-relative
/// acceleration. A pure function of the calls, in their order: live and replay give the same bits. Method:
/// docs/method/fusion.md; symbols (Z_i, N_i, P_i, C): docs/reference/frames.md. Thread: one at a time. No
/// allocation in add and tick after the first tick, but where a calibration is made (once a phase).
class Pipeline {
 public:
  explicit Pipeline(const sensor::Rig& rig, const PipelineSettings& settings = {});
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;
  ~Pipeline();

  /// A guided step of the prologue, [begin, end) on the reference sensor's clock; given before the tick of
  /// its begin. An empty one, and Step::none, is ignored.
  void mark(tracker::Step step, DeviceTime begin, DeviceTime end);
  /// Cancels guidance: the calibration in force before the first mark is restored.
  void cancel_marks();
  /// The performer rests on the frames [begin, end), as in the calibration's neutral: the first tick at or
  /// after `end` corrects headings and creep by it, before its features. Given before the tick of `begin`;
  /// replaces a rest that has not ended. A calibration that is put in force meanwhile cancels it. Nods and
  /// skin correct nothing during a rest.
  void rest(DeviceTime begin, DeviceTime end);
  /// Whether a rest corrects anything: a calibration is in force, and its drift is followed.
  [[nodiscard]] bool follows_drift() const;
  /// What the last tick's end of a rest came to; none at any other tick.
  [[nodiscard]] const std::optional<tracker::RestOutcome>& rested() const;

  /// A decoded sample as it arrives, in the log's order. One that was overtaken is integrated in its place,
  /// as if it had come in time, where fewer than 56 have come that are newer. Ignored: samples of unknown
  /// sensors, of other modalities, with values that are not finite, that came before, or come later than
  /// that.
  void add(const sensor::Sample& sample);
  /// The sensor's next samples come from another board, with another bias, clock, heading and mounting. A
  /// face sensor is then missing until the next calibration; for the ear sensor the calibration is discarded.
  void forget(std::uint16_t sensor);

  /// Features of the frame at `frame` (reference sensor's clock): orientations interpolated between fused
  /// samples, or extrapolated, then held. Missing are sensors silent for longer than the limit, sensors too
  /// uncertain (unsure_rad), and all before a calibration. `out.sensors`: one entry a face sensor, in the
  /// rig's order: rotation E_i and acceleration, frame H.
  /// `lines`: every sensor's clock model, with all samples that were added. Returns what became of the
  /// calibration, if anything, without its modality; never withdrawn.
  std::optional<tracker::CalibrationEvent> tick(DeviceTime frame, const sensor::TimeLines& lines,
                                                model::FeatureFrame& out);

  /// The calibration in force; identity before one.
  [[nodiscard]] const Calibration& calibration() const;
  /// The same with the present headings and the adhesive's creep in the neutrals: for restore().
  [[nodiscard]] Calibration calibration_now() const;
  /// The guided step in progress, or the one that self-calibration waits for; Step::none otherwise.
  [[nodiscard]] tracker::Step step() const;
  /// Why self-calibration rejected the last nod; empty otherwise. A string literal.
  [[nodiscard]] std::string_view hint() const;
  /// Puts an earlier calibration in force. Headings of six-axis fusions are valid only within one session.
  /// Errors: mismatch (another number of sensors).
  [[nodiscard]] Result<void> restore(const Calibration& calibration);

  /// Status of one sensor, by its number in the rig; zeros for any other number.
  [[nodiscard]] SensorStatus status(std::uint16_t sensor) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mien::imu
