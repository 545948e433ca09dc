#pragma once

#include <optional>

#include "mien/core/rotation.h"

namespace mien::imu {

/// Settings of the nod measurement. Defaults: docs/method/fusion.md.
struct NodSettings {
  /// Stillness: the face's rate against the head (low-passed by 0.1 s) must be below `still_rad_s`, rad/s (4
  /// deg/s), plus `still_share` of the head's own rate (gyroscope scale errors), for `still_s`, s. Raising
  /// the first two: slowly moving faces, and worse gyroscope scales, pass as still: more measurements, some
  /// biased. Lowering: fewer measurements, and none of quick nods. Raising the third: short rests between
  /// expressions give no measurement; lowering: they do.
  double still_rad_s = 0.07;
  double still_share = 0.03;
  double still_s = 0.3;
  /// Least information on the heading for a measurement: squared path of the vertical in the head, rad^2,
  /// summed over 60 Hz frames, less the share of inclination errors. Raising: rarer, more certain
  /// measurements. Lowering: more frequent, noisier ones.
  double min_information = 3;
  /// A stretch without enough information after this time is discarded, s. Raising: slow nods still add up,
  /// drift within them smears. Lowering: slow nods give no measurement.
  double max_stretch_s = 4.0;
  /// Measurement noise: standard deviation of one frame's orientation, rad (0.4 deg), and the number of
  /// successive frames that share one error. Raising either: measurements weigh less. Lowering: more.
  double frame_sigma_rad = 0.007;
  double correlated_frames = 8;
  /// Prior standard deviation of the difference of the two fusions' inclination errors, rad (1.5 deg), which
  /// are estimated beside the heading. Raising: more is attributed to inclinations, measurements weigh less.
  /// Lowering: inclination errors bias the heading.
  double tilt_sigma_rad = 0.026;
  /// Gate: largest RMS residual of a stretch, rad (1 deg); above it the face moved. Raising: stretches of
  /// moving faces are accepted. Lowering: more stretches are rejected.
  double max_residual_rad = 0.0175;
};

/// What a nod tells of a heading.
struct NodMeasurement {
  double error_rad = 0;  ///< The heading's estimate less the truth.
  double sigma_rad = 0;  ///< Standard deviation.
};

/// Finds stretches in which the face is still while the head tilts. A heading error e of one face sensor then
/// turns P_i by R_h^T e plus a constant; least squares over the stretch gives the vertical part of e, with
/// both sensors' inclination errors removed. Frames and symbols: docs/reference/frames.md; method:
/// docs/method/fusion.md. A value type. No allocation.
class NodWatch {
 public:
  explicit NodWatch(const NodSettings& settings = {}) : settings_(settings) {}

  /// One frame. `q_ear_face` is P_i at the present heading estimate; `q_world_ear` is R_h; `rate_rad_s` the
  /// rate of the face sensor against the ear sensor, `head_rate_rad_s` the ear sensor's own; both in the ear
  /// sensor's axes. A measurement where a stretch has just told enough.
  [[nodiscard]] std::optional<NodMeasurement> add(double dt_s, const Quat& q_ear_face,
                                                  const Quat& q_world_ear, const Vec3& rate_rad_s,
                                                  const Vec3& head_rate_rad_s);
  /// The present stretch ends: a sensor was missing, or the heading was moved.
  void interrupt() { still_s_ = 0; }

 private:
  void begin(const Quat& q_ear_face);

  NodSettings settings_;
  Vec3 smooth_rate_ = Vec3::Zero();
  double still_s_ = 0;
  // The current stretch of a still face.
  double stretch_s_ = 0;
  double n_ = 0;
  Quat from_ = Quat::Identity();
  Mat3 world_sum_ = Mat3::Zero();  // Of R_h.
  Vec3 turn_sum_ = Vec3::Zero();   // Of P_i's turns since the stretch began, ear sensor's axes.
  Vec3 world_turn_sum_ = Vec3::Zero();
  double turn_turn_ = 0;
};

}  // namespace mien::imu
