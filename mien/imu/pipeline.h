#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "mien/core/time.h"
#include "mien/imu/calibration.h"
#include "mien/imu/fusion.h"
#include "mien/imu/heading.h"
#include "mien/imu/self_calibration.h"
#include "mien/model/features.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"

namespace mien::imu {

/// The steps of the prologue.
enum class Phase : std::uint8_t {
  neutral,  ///< Face and head still, upright, looking ahead.
  nod,      ///< Face still, the head nods; begins downwards.
  shake,    ///< Face still, the head shakes about the vertical.
};

/// A phase that was found by watching.
struct FoundPhase {
  Phase phase;
  DeviceTime begin, end;
};

/// The step that a take's event of this kind marks ("neutral", "nod", "shake"); none for any other.
[[nodiscard]] std::optional<Phase> phase_of(std::string_view event_kind);

/// What became of the calibration at a frame.
struct CalibrationChange {
  enum class Kind : std::uint8_t {
    none,
    calibrated,  ///< A prologue's phase, or watching, put one in force.
    judged,      ///< The shake scored the one in force.
  };
  Kind kind = Kind::none;
  std::vector<FoundPhase> found;  ///< The phases by which watching made or judged it.
};

struct PipelineSettings {
  FusionSettings fusion;
  HeadingSettings heading;
  /// Fuse the magnetometer where samples carry one. All headings are then magnetic ones, and Z_i is the
  /// identity. Off: a heading from a magnetometer near electronics is worse (5 deg) than the relative one
  /// that nods give.
  bool magnetometer = false;
  /// Follow the headings' drift after the prologue. Off: they stay as the prologue found them.
  bool track_heading = true;
  /// A sensor whose heading is followed, and with what gaps left of its tilt less sure than this, is missing,
  /// rad (17 deg): a wrong rotation costs a face more than none. Above what a self-calibration accepts.
  double unsure_rad = 0.3;
  /// While there is no calibration, watch for a still face, a nod and a shake, and calibrate by them.
  bool calibrates_itself = false;
  /// A sensor whose newest sample is older than this at a frame is missing. Raising hides drop-outs behind
  /// held values.
  Duration silence = std::chrono::milliseconds(100);
  /// The same for a board that sends nothing while its rotation stays as it is, and no device time.
  Duration unchanged = std::chrono::seconds(1);
  /// A frame later than the newest sample is predicted with the last rate, this far at most, and held beyond
  /// it.
  Duration prediction = std::chrono::milliseconds(25);
};

/// How well a sensor's rotation is known now, for people and for trackers.
struct SensorStatus {
  double heading_rad = 0;        ///< Z_i in force.
  double heading_sigma_rad = 0;  ///< Its standard deviation; grows while nothing tells it.
  double tilt_sigma_rad = 0;     ///< What gaps left of its tilt, and gravity has not mended.
  std::uint64_t dropped = 0;     ///< Samples that came out of order or twice.
  std::uint64_t lost = 0;        ///< Samples that never came, as the gaps in device time tell.
};

/// From decoded IMU samples to features: fusion, prologue, removal of the head's rotation, head-relative
/// acceleration. A pure function of the calls, in their order: live and replay give the same bits. Method:
/// docs/method/fusion.md. Thread: one at a time. No allocation in add and tick after the first tick, but
/// where a calibration is made (once a phase).
class Pipeline {
 public:
  explicit Pipeline(const sensor::Rig& rig, const PipelineSettings& settings = {});
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;
  ~Pipeline();

  /// A prologue phase in reference-device time, [begin, end); given before the tick of its begin.
  void mark(Phase phase, DeviceTime begin, DeviceTime end);
  /// Forgets the marks; what was in force before the first of them, since none ran, is in force again.
  void cancel_marks();

  /// A decoded sample as it arrives. Order of calls is the log's order. Samples of unknown sensors and of
  /// other modalities are ignored.
  void add(const sensor::Sample& sample);
  /// The sensor's next samples are another board's: another bias, clock and heading, and fixed in another
  /// way. Without a neutral of its own a face sensor is missing until the next calibration; without the
  /// ear's there is none.
  void forget(std::uint16_t sensor);

  /// Features of the frame at `frame` (reference sensor's clock): orientations interpolated between fused
  /// samples, or predicted, then held, when nothing newer came; a sensor silent for longer than the limit is
  /// missing, and so is every one before a calibration. `out.sensors` gets one entry a face sensor. Samples
  /// of the lab profile need no calibration. `lines`: every sensor's clock, with all samples that were added.
  CalibrationChange tick(DeviceTime frame, const sensor::TimeLines& lines, model::FeatureFrame& out);

  /// After the prologue; identity before, and for lab.
  [[nodiscard]] const Calibration& calibration() const;
  /// The same with the headings as they are followed now, and neutrals with what the adhesive has crept: what
  /// restore() may put in force again.
  [[nodiscard]] Calibration calibration_now() const;
  /// The phase that runs, or that is watched for; none when a calibration is in force and nothing runs.
  [[nodiscard]] std::optional<Phase> phase() const;
  /// Why the last nod that was watched did not do; empty when it did.
  [[nodiscard]] std::string_view hint() const;
  /// Puts an earlier calibration in force. Headings of six-axis fusions hold only within one session.
  /// Errors: mismatch (another number of sensors).
  [[nodiscard]] Result<void> restore(const Calibration& calibration);

  /// Of one sensor of the rig, by its number in the rig.
  [[nodiscard]] SensorStatus status(std::uint16_t sensor) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace mien::imu
