#pragma once

#include <cstddef>
#include <optional>

#include "mien/core/covariance.h"
#include "mien/core/rotation.h"
#include "mien/imu/skin_turns.h"

namespace mien::imu {

/// Z(angle): the rotation about the vertical, +Y, from one fusion's world frame to another's.
[[nodiscard]] Quat heading_turn(double angle_rad);

/// Sums of P(Z) = R_h^T Z R_i over frames, for every Z at once: Z is linear in 1, cos and sin of its angle,
/// so three 3 x 3 sums suffice for a search over all headings. No frame is stored. Frames and symbols:
/// docs/reference/frames.md; method: docs/method/calibration.md.
class HeadingSums {
 public:
  /// One frame: R_h and R_i, orientations of ear sensor and face sensor, each in its own fusion's world.
  void add(const Quat& q_world_ear, const Quat& q_world_face);
  HeadingSums& operator+=(const HeadingSums& other);
  [[nodiscard]] std::size_t count() const { return count_; }
  /// The mean of P at a heading, projected onto the nearest rotation.
  [[nodiscard]] Quat mean(double heading_rad) const;
  /// Root mean square angle of P from its mean at a heading, rad.
  [[nodiscard]] double spread(double heading_rad) const;

  struct Best {
    double heading_rad = 0;  ///< (-pi, pi]: where the spread of P is least.
    /// Standard deviation, from the remaining spread and how far the head tilted; pi where it did not tilt.
    double sigma_rad = 0;
  };
  /// The heading of least spread. Fewer than two frames: 0 with a sigma of pi.
  [[nodiscard]] Best find() const;

 private:
  [[nodiscard]] double squared_sum(double heading_rad) const;
  Mat3 constant_ = Mat3::Zero();
  Mat3 cosine_ = Mat3::Zero();
  Mat3 sine_ = Mat3::Zero();
  Vec3 up_sum_ = Vec3::Zero();  // Sum of the vertical in the ear sensor's axes.
  std::size_t count_ = 0;
};

/// Settings of the heading tracker. Defaults: docs/method/fusion.md; those of re-centring were chosen by
/// `mien study drift`, those of skin by `mien study settings heading` (docs/experiments/settings.md). "Weigh
/// less": the Kalman gain of that measurement falls, so drift is corrected later and the state is steadier.
struct HeadingSettings {
  // Nods of a still face.
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

  // Process noise.
  /// Random walk of the heading, rad a root s (0.03 deg). Raising: uncertainty grows faster, measurements
  /// weigh more. Lowering: drift is followed later.
  double heading_walk = 5e-4;
  /// Random walk of the heading's rate, rad/s a root s. Biases wander slowly (0.05 deg/s a root minute), but
  /// nodding and turning at once turns half a percent of gyroscope scale into 0.1 deg/s. Raising: changes of
  /// the rate are followed sooner. Lowering: a steadier rate.
  double rate_walk = 6e-4;
  /// Standard deviation of the rate after a calibration, rad/s (0.15 deg/s). Raising: the rate is found
  /// sooner, the heading is less certain meanwhile. Lowering: it is found later.
  double rate_sigma_rad_s = 2.6e-3;
  /// Time constant with which the rate decays to 0, s, as the motion ends that caused it. Raising: a rate
  /// persists longer after a motion. Lowering: it is forgotten sooner.
  double rate_tau_s = 30;
  /// Random walk of the adhesive's creep, rad a root s and axis (0.5 deg a root minute, as of the rig's
  /// faults); used only with SkinTurns. Raising: creep is followed sooner, held expressions fade into
  /// neutral. Lowering: creep remains; 0: none is tracked.
  double slip_walk = 1.13e-3;

  // Slow re-centring, without SkinTurns: skin returns to rest, so its turn about the vertical measures the
  // heading error.
  /// Standard deviation of that measurement, rad (3 deg). Raising: measurements weigh less. Lowering: drift
  /// is held tighter, held expressions are bent towards rest sooner. 0 switches off re-centring, the skin
  /// measurements (add_skin) and the search for lost headings.
  double neutral_sigma_rad = 0.05;
  /// Time in which the frames' measurements add up to one of that standard deviation, s. Raising and
  /// lowering: as above.
  double neutral_every_s = 8;
  /// Growth of that standard deviation with the skin's tilt from neutral (which gravity determines), rad a
  /// rad. Raising: tilted skin weighs less. Lowering: expressions bias the heading.
  double neutral_tilt = 0.3;
  /// Prior standard deviation of the turn about the vertical, from neutral, at which skin rests, rad (8 deg);
  /// estimated while the heading is still certain from the calibration, and kept. Raising: a lasting turn is
  /// attributed to where skin rests. Lowering: to the heading; 0: skin rests at neutral.
  double rest_sigma_rad = 0.14;
  /// Innovation gate, standard deviations (of heading and measurement together), of re-centring and of skin
  /// measurements: beyond it the turn is an expression and is ignored. (For the latter's three components the
  /// gate is 1.74 times its square, as rare.) Raising: more is accepted, expressions bias the heading.
  /// Lowering: a heading that has drifted far is not corrected.
  double neutral_gate = 2.5;

  // Skin measurements, with SkinTurns: the residual of a sensor's rotation beyond what all sensors' tilts
  // predict.
  /// Measurement noise, in standard deviations of that prediction (residual_cov_rad2). Raising: measurements
  /// weigh less. Lowering: drift is held tighter, held expressions are bent sooner.
  double predicted_sigmas = 1.2;
  /// Time in which the frames' measurements add up to one of that noise, s. Raising and lowering: as above.
  double predicted_every_s = 1.0;
  /// Prior standard deviation of the wearer-specific skin rotation, in the same unit. Raising: residuals are
  /// attributed to the wearer's skin. Lowering: to the heading.
  double wearer_rotation_sigmas = 1.6;

  // Search for a lost heading: a turn about the vertical beyond `lost_turn_rad` to one side for
  // `lost_after_s`, while the heading's standard deviation is above `lost_sigma_rad`, is attributed to the
  // heading, by the least of those turns.
  /// rad (15 deg). Raising: lost headings stay lost. Lowering: held expressions are taken for lost headings.
  double lost_turn_rad = 0.26;
  /// s. Raising: found later. Lowering: held expressions are taken for lost headings.
  double lost_after_s = 6;
  /// rad (7 deg). Raising: only very uncertain headings are searched. Lowering: fairly certain ones are moved
  /// too.
  double lost_sigma_rad = 0.12;
};

/// Kalman filter of one face sensor's heading error after the prologue. States: heading error, its rate, the
/// wearer-specific skin rotation (three) and the adhesive's creep (three). Measurements: nods of a still
/// face, where a heading error e turns P_i by R_h^T e plus a constant (least squares over the stretch, with
/// both inclination errors); and the skin, by SkinTurns or slow re-centring. Without measurements the
/// uncertainty grows. Frames: docs/reference/frames.md; method: docs/method/fusion.md. A value type. No
/// allocation.
class HeadingTracker {
 public:
  explicit HeadingTracker(const HeadingSettings& settings = {}) : settings_(settings) {}
  /// From a calibration: Z_i's angle and its standard deviation, rad. `residual_cov_rad2`: 3 x 3 covariance
  /// of the skin's prediction (SkinTurns::nominal_cov_rad2()), where there is one.
  void start(double heading_rad, double sigma_rad, const std::optional<Mat3>& residual_cov_rad2 = {});
  /// Sets another heading and keeps what was estimated of the skin and the creep: the sensor's fusion was
  /// restarted.
  void move_to(double heading_rad, double sigma_rad);
  /// Z_i's angle now, (-pi, pi].
  [[nodiscard]] double heading_rad() const { return heading_; }
  /// Its standard deviation, rad, at most pi.
  [[nodiscard]] double sigma_rad() const;
  /// Whether the covariance is one (is_covariance()); else the filter is defective.
  [[nodiscard]] bool sound() const { return is_covariance(cov_); }
  /// The adhesive's creep since start(): rotation vector, frame H, rad; 0 without add_skin().
  [[nodiscard]] const Vec3& slip_rad() const { return slip_; }
  /// Adds the heading uncertainty of a gap, one standard deviation, rad.
  void inflate(double sigma_rad) { cov_(0, 0) += sigma_rad * sigma_rad; }

  /// One frame. `q_ear_face` is P_i at heading_rad(); `q_world_ear` is R_h; `rate_rad_s` the rate of the face
  /// sensor against the ear sensor, `head_rate_rad_s` the ear sensor's own; both in the ear sensor's axes.
  void add(double dt_s, const Quat& q_ear_face, const Quat& q_world_ear, const Vec3& rate_rad_s,
           const Vec3& head_rate_rad_s);
  /// Slow re-centring, after add(): the skin's turn from neutral about the vertical at heading_rad(), and its
  /// tilt from neutral, rad.
  void add_turn_from_neutral(double dt_s, double turn_rad, double tilt_rad);
  /// The skin measurement instead, where SkinTurns predicts the sensor. `dt_s`: since the last one.
  void add_skin(double dt_s, const SkinMeasurement& measurement);
  /// One frame in which this sensor or the ear's was missing: prediction only.
  void skip(double dt_s);

 private:
  /// Heading error, its rate, wearer-specific skin rotation (3), adhesive's creep (3).
  static constexpr int kStates = 8;
  using StateVec = Eigen::Matrix<double, kStates, 1>;
  using StateMat = Eigen::Matrix<double, kStates, kStates>;
  void predict(double dt_s);
  void begin(const Quat& q_ear_face);
  /// Search for a lost heading; true when it has just moved the heading. `wearer_rad`: the part of the turn
  /// that is the wearer-specific skin rotation.
  bool recover_lost_heading(double dt_s, double turn_rad, double wearer_rad);
  /// Kalman update by a scalar measurement with this row of the observation matrix.
  void correct(const StateVec& observation, double innovation_rad, double sigma_rad);
  void move_by(const StateVec& change);

  HeadingSettings settings_;
  double heading_ = 0;
  double rate_ = 0;
  /// Wearer-specific skin rotation: rotation vector beyond the prediction at strength 1, frame H, rad.
  /// Without SkinTurns, where the skin rests: only +Y is used, its turn about the vertical.
  Vec3 wearer_rotation_ = Vec3::Zero();
  Vec3 slip_ = Vec3::Zero();  // Creep since the calibration: rotation vector, frame H, rad.
  StateMat cov_ = StateMat::Zero();
  Vec3 smooth_rate_ = Vec3::Zero();
  double still_s_ = 0;
  double lost_s_ = 0;           // How long the turn has been beyond lost_turn_rad to one side, ...
  double lost_least_rad_ = 0;   // ... the smallest turn meanwhile, ...
  double lost_wearer_rad_ = 0;  // ... and the wearer's part of it.
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
