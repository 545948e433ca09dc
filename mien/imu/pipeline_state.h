#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "mien/imu/drift_filter.h"
#include "mien/imu/heading.h"
#include "mien/imu/nod_watch.h"
#include "mien/imu/pipeline.h"
#include "mien/imu/prologue.h"
#include "mien/imu/rest_measurement.h"
#include "mien/imu/self_calibration.h"
#include "mien/imu/sensor_channel.h"
#include "mien/sensor/clock_model.h"
#include "mien/sensor/rig.h"
#include "mien/sensor/sample.h"

namespace mien::imu {

/// A guided step of the prologue, [begin, end) on the reference sensor's clock.
struct StepWindow {
  tracker::Step step;
  DeviceTime begin;
  DeviceTime end;
  bool begun = false;
};

/// A rest that a person asked for, [begin, end) on the reference sensor's clock.
struct RestWindow {
  DeviceTime begin;
  DeviceTime end;
  bool begun = false;
};

/// The pipeline's state and steps; internal to pipeline*.cpp. Symbols: docs/reference/frames.md.
struct Pipeline::State {
  State(const sensor::Rig& rig, const PipelineSettings& s)
      : settings(s),
        face(rig.face_sensors()),
        head(rig.head_sensor()),
        channels(rig.sensors.size(), Channel(s.fusion)),
        prologue(rig),
        watch(rig),
        drift(s.drift, rig.skin, rig.face_sensor_names()),
        nods(face.size(), NodWatch(s.nod)),
        rest_measurement(face.size()),
        turns_rad(face.size()),
        tilt_rad2(face.size()),
        implausible_s(face.size()),
        lever_m(face.size()) {
    calibration.sensors.resize(face.size());
    prologue_frame.face.resize(face.size());
    if (!head || !rig.sensors[*head].position_m) return;
    for (std::size_t i = 0; i < face.size(); ++i)
      if (rig.sensors[face[i]].position_m)
        lever_m[i] = *rig.sensors[face[i]].position_m - *rig.sensors[*head].position_m;
  }

  // Input: pipeline_input.cpp.
  /// Restart detection, and the sample's place among those that came: integrated at once behind the newest,
  /// by catch_up() where it was overtaken.
  void add(Channel& channel, const FusionInput& in);
  /// Integrates the samples that are not, after late ones.
  void catch_up(Channel& channel);
  void integrate(Channel& channel, const FusionInput& in);
  void integrate_raw(Channel& channel, const FusionInput& in, double dt_s);
  void integrate_fused(Channel& channel, const FusionInput& in, double dt_s);
  /// What gaps have added to the sensor's orientation since the last call.
  Gaps take_gaps(std::uint16_t sensor, DeviceTime frame);
  /// The sensor's orientation at the frame; none where nothing was received lately.
  [[nodiscard]] std::optional<FusedSample> pose(std::uint16_t sensor, DeviceTime frame) const;
  /// The ear sensor's orientation in a gap of at most `bridge`, by what the face sensors turned since its
  /// newest sample; rate and force are that sample's. None without a calibration, or where too few face
  /// sensors are there.
  [[nodiscard]] std::optional<FusedSample> bridged_ear(DeviceTime frame) const;
  // Calibration: pipeline_calibration.cpp.
  void run_prologue(DeviceTime frame, const std::optional<FusedSample>& ear);
  void watch_for_calibration(DeviceTime frame, const std::optional<FusedSample>& ear);
  /// `only_fresh`: a rotation held over a gap counts as missing.
  void fill_prologue_frame(DeviceTime frame, const FusedSample& ear, bool only_fresh);
  /// Whether the frame's orientation is no more than a prediction from the newest sample.
  [[nodiscard]] bool fresh(std::uint16_t sensor, DeviceTime frame) const;
  void put_in_force(const Calibration& made);
  /// A shake scores the calibration in force, and changes nothing else.
  void judge(const Calibration& made);
  [[nodiscard]] bool follows_drift() const {
    return settings.track_heading && !settings.magnetometer && calibration.complete;
  }
  /// Whether the frame belongs to a rest. At the end of one drift is corrected.
  bool follow_rest(DeviceTime frame);
  void conclude_rest();
  /// E_i of all poses of the frame, into `turns_rad`, and the vertical.
  void measure_turns(const Quat& q_world_ear);
  /// P_i of the frame; the pose is present.
  [[nodiscard]] Quat relative(std::size_t i, const Quat& q_world_ear) const;
  /// C with the ear sensor's creep since the calibration.
  [[nodiscard]] Quat q_head_ear() const {
    return exp_rotation(drift.ear_creep_rad()) * calibration.q_head_ear;
  }
  /// N_i with both sensors' creep since the calibration: q_head_ear() P_i N_i^T q_head_ear()^T is E_i.
  [[nodiscard]] Quat neutral(std::size_t i) const {
    const Quat& c = calibration.q_head_ear;
    return c.conjugate() * exp_rotation(-drift.ear_creep_rad()) * exp_rotation(drift.creep_rad(i)) * c *
           calibration.sensors[i].neutral;
  }
  /// Another heading of a face sensor, whose fusion restarted.
  void move_heading(std::size_t i, double heading_rad, double sigma_rad) {
    drift.move_to(i, heading_rad, sigma_rad);
    nods[i].interrupt();
    rest_measurement.forget(i);
  }
  [[nodiscard]] bool self_calibrating() const {
    return settings.calibrates_itself && windows.empty() &&
           (!calibration.complete || (watched && !watch.finished()));
  }
  /// After a restart of the ear sensor: the common turn that brings all skin nearest to neutral.
  void realign_head(DeviceTime frame, const FusedSample& ear);
  /// After a restart of a face sensor: the heading that brings its skin nearest to neutral.
  void realign_face(std::size_t i, const FusedSample& ear, const FusedSample& sensor);
  /// Whether a face sensor's turn about the vertical is beyond what skin can do: it is then left out, and
  /// realigned after kImplausibleFor_s.
  bool implausible(std::size_t i, double dt_s, const FusedSample& ear, const FusedSample& sensor);
  /// The heading that brings the sensor's skin nearest to neutral, rad.
  [[nodiscard]] double nearest_neutral(std::size_t i, const FusedSample& ear,
                                       const FusedSample& sensor) const;
  /// Standard deviation of a sensor's rotation: heading and tilt, root sum of squares.
  [[nodiscard]] double rotation_sigma_rad(std::size_t i) const {
    return std::hypot(drift.heading_sigma_rad(i), std::sqrt(tilt_rad2[i]));
  }
  /// Whether the sensor is left out for its uncertainty.
  [[nodiscard]] bool is_unsure(std::size_t i) const {
    return follows_drift() && rotation_sigma_rad(i) > settings.unsure_rad;
  }
  /// Z_i.
  [[nodiscard]] Quat turn_of(std::size_t i) const {
    return settings.magnetometer ? Quat::Identity() : heading_turn(drift.heading_rad(i));
  }

  PipelineSettings settings;
  std::vector<std::uint16_t> face;  // Numbers in the rig.
  std::optional<std::uint16_t> head;
  const sensor::TimeLines* lines = nullptr;  // During a tick.
  std::vector<Channel> channels;             // One a sensor of the rig.
  Prologue prologue;
  Prologue::Frame prologue_frame;
  std::vector<StepWindow> windows;
  SelfCalibration watch;
  bool watched = false;  // The calibration in force is a self-calibration.
  Calibration calibration;
  std::optional<tracker::CalibrationEvent> change;  // At the current frame.
  Calibration before_marks;                         // In force at the first mark, ...
  bool changed_by_marks = false;                    // ... and whether it has been replaced since.
  Quat last_head = Quat::Identity();                // Of the last frame that had one.
  DriftFilter drift;
  std::vector<NodWatch> nods;  // One a face sensor.
  std::optional<RestWindow> rest;
  RestMeasurement rest_measurement;
  std::optional<tracker::RestOutcome> rested;  // Of the current frame.
  std::vector<std::optional<Vec3>> turns_rad;  // E_i of the frame, by face sensor.
  // By face sensor: variance of its tilt after gaps, decaying with the inclination correction.
  std::vector<double> tilt_rad2;
  std::vector<double> implausible_s;              // By face sensor: how long its turn has been implausible.
  std::vector<std::optional<FusedSample>> poses;  // Of the frame, by face sensor.
  std::vector<std::optional<Vec3>> lever_m;       // From the ear sensor, frame H.
  Vec3 last_up = Vec3::UnitY();                   // The vertical at the last measured frame, frame H.
  std::optional<DeviceTime> last_frame;
  std::optional<Vec3> last_head_rate;  // Frame H, at last_frame.
};

}  // namespace mien::imu
