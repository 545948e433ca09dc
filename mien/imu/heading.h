#pragma once

#include <cstddef>
#include <optional>

#include "mien/core/rotation.h"
#include "mien/imu/skin_turns.h"

namespace mien::imu {

/// Z(angle): the turn about the vertical that brings one fusion's world to another's.
[[nodiscard]] Quat heading_turn(double angle_rad);

/// Sums of P(Z) = R_h^T Z R_i over frames, for every Z at once: Z is linear in 1, cos and sin of its angle,
/// so three 3 x 3 sums hold all that a search over the heading needs. No frame is kept.
class HeadingSums {
 public:
  /// One frame: orientations of ear sensor and face sensor in their own fusions' worlds.
  void add(const Quat& q_world_ear, const Quat& q_world_face);
  HeadingSums& operator+=(const HeadingSums& other);
  [[nodiscard]] std::size_t count() const { return count_; }
  /// The mean of P at a heading, brought back to a rotation.
  [[nodiscard]] Quat mean(double heading_rad) const;
  /// Root mean square angle of P from its mean at a heading, rad.
  [[nodiscard]] double spread(double heading_rad) const;

  struct Best {
    double heading_rad = 0;  ///< (-pi, pi]: P is most constant.
    double sigma_rad =
        0;  ///< From the spread that is left and how much the head tilted; pi when it did not tilt.
  };
  [[nodiscard]] Best find() const;

 private:
  [[nodiscard]] double squared_sum(double heading_rad) const;
  Mat3 constant_ = Mat3::Zero();
  Mat3 cosine_ = Mat3::Zero();
  Mat3 sine_ = Mat3::Zero();
  Vec3 up_sum_ = Vec3::Zero();  // Of the vertical in the ear sensor's axes.
  std::size_t count_ = 0;
};

struct HeadingSettings {
  /// The face is still when it turns slower than this against the head (smoothed over 0.1 s), rad/s (4
  /// deg/s), ...
  double still_rad_s = 0.07;
  /// ... and this share of the head's own rate, which gyroscopes' scales make of it, ...
  double still_share = 0.03;
  /// ... for this long, s.
  double still_s = 0.3;
  /// A stretch ends when its tilts tell the heading: so many squared paths of the vertical in the head,
  /// summed over 60 Hz frames, are left after the inclinations' share is taken out.
  double min_information = 3;
  /// A stretch that told nothing after this time begins anew, s.
  double max_stretch_s = 4.0;
  /// Standard deviation of one frame's orientation error, rad (0.4 deg), and the frames over which it is the
  /// same error.
  double frame_sigma_rad = 0.007;
  double correlated_frames = 8;
  /// Standard deviation of the difference of two fusions' inclinations, rad (1.5 deg): it moves with the head
  /// too.
  double tilt_sigma_rad = 0.026;
  /// A stretch whose rotation does not follow the tilt to this, rad (1 deg), was a moving face.
  double max_residual_rad = 0.0175;
  /// How the difference of two gyroscopes' rates about the vertical wanders, rad/s per root s, and how unsure
  /// it is at first, rad/s (0.15 deg/s). Biases wander slowly (0.05 deg/s a root minute); but nodding and
  /// turning at once turns half a percent of scale into a tenth of a degree a second, and stops when the head
  /// does.
  double rate_walk = 6e-4;
  double rate_sigma_rad_s = 2.6e-3;
  /// The rate's time constant, s: it dies away as the motion that made it does.
  double rate_tau_s = 30;
  /// Slow re-centring. Skin comes back to where it rests: a turn about the vertical that is small against
  /// what the heading may be off is taken as a reading of the heading, of this standard deviation, rad (3
  /// deg; 0 switches it off), once in this time, s. Lowering either holds drift tighter, and bends held
  /// expressions towards rest sooner. All of these chosen by `mien study drift` (docs/method/fusion.md).
  double neutral_sigma_rad = 0.05;
  double neutral_every_s = 8;
  /// Gravity holds the skin's tilt, and skin that is tilted away from neutral is turned too: each radian of
  /// tilt adds so much to that standard deviation.
  double neutral_tilt = 0.3;
  /// How far about the vertical from its neutral skin rests, one sigma, rad (8 deg): that is learnt while the
  /// heading is still well known from the calibration, and kept. 0: it rests at its neutral.
  double rest_sigma_rad = 0.14;
  /// Beyond this many sigmas (heading's and skin's together) it is an expression and says nothing.
  double neutral_gate = 2.5;
  /// Where it is known how skin turns (SkinTurns), what is seen beyond that is such a reading instead: of so
  /// many of its own standard deviations (people differ, and hold what they do), once in this time, s; and
  /// skin has a way of its own, one sigma, so many from what is foretold. neutral_sigma_rad of 0 switches
  /// these off too, the gate is the same. Chosen on virtual people and one real take (docs/method/fusion.md):
  /// fewer sigmas or seconds hold drift tighter, and bend held expressions sooner.
  double foretold_sigmas = 1.67;
  double foretold_every_s = 1.4;
  double foretold_way_sigmas = 1.1;
  /// A heading that got lost: no skin stays this far from neutral, rad (15 deg), to one side, for so long, s,
  /// while the heading is as unsure as this, rad (7 deg). Then the least of those turns was the heading's.
  double lost_turn_rad = 0.26;
  double lost_after_s = 6;
  double lost_sigma_rad = 0.12;
  /// How the heading itself wanders, rad per root s (0.03 deg).
  double heading_walk = 5e-4;
  /// How the adhesive creeps, rad per root s (0.5 deg a root minute), where it is known how skin turns: a
  /// turn from neutral that a face at rest keeps is the sensor's. 0: it holds.
  double slip_walk = 1.13e-3;
};

/// Follows one sensor's heading error after the prologue. Where the head tilts while the face is still, an
/// error e of the world (a turn about the vertical, and what the inclinations differ) turns P by R_h^T e plus
/// a constant: three numbers by least squares, of which the vertical one corrects the heading and, over time,
/// its rate. Elsewhere the uncertainty grows.
class HeadingTracker {
 public:
  explicit HeadingTracker(const HeadingSettings& settings = {}) : settings_(settings) {}
  /// From a calibration. `strays_rad2`: how skin strays from what is foretold (SkinReading), where that is
  /// known.
  void start(double heading_rad, double sigma_rad, const std::optional<Mat3>& strays_rad2 = {});
  /// The same sensor on the same skin has another heading: its fusion began anew.
  void move_to(double heading_rad, double sigma_rad);
  /// Z's angle now.
  [[nodiscard]] double heading_rad() const { return heading_; }
  [[nodiscard]] double sigma_rad() const;
  /// How the sensor has crept on its skin since start(), a rotation vector in frame H, rad; known where it is
  /// known how skin turns.
  [[nodiscard]] const Vec3& slip_rad() const { return slip_; }
  /// Something else made it unsure: a gap, by so much.
  void inflate(double sigma_rad) { cov_(0, 0) += sigma_rad * sigma_rad; }

  /// One frame. `q_ear_face` is P at heading_rad(); `q_world_ear` is R_h; `rate_rad_s` the rate of the face
  /// sensor against the ear sensor, `head_rate_rad_s` the ear sensor's own; both in its axes.
  void add(double dt_s, const Quat& q_ear_face, const Quat& q_world_ear, const Vec3& rate_rad_s,
           const Vec3& head_rate_rad_s);
  /// The skin's turn about the vertical at heading_rad() in the same frame, rad, and how far it is tilted
  /// away from neutral, rad: for the slow re-centring, and for finding a lost heading again.
  void add_turn_from_neutral(double dt_s, double turn_rad, double tilt_rad);
  /// The same where it is known how skin turns.
  void add_skin(double dt_s, const SkinReading& reading);
  /// One frame in which the sensor or the ear's was missing.
  void skip(double dt_s);

 private:
  /// Heading, rate, the skin's way (3), and the adhesive's slip (3).
  static constexpr int kStates = 8;
  using StateVec = Eigen::Matrix<double, kStates, 1>;
  using StateMat = Eigen::Matrix<double, kStates, kStates>;
  void predict(double dt_s);
  void begin(const Quat& q_ear_face);
  /// True when it has just found a lost heading again. `way_rad`: what of the turn is the skin's own.
  bool find_again(double dt_s, double turn_rad, double way_rad);
  /// A reading of the state by these shares, that is by so much beyond it.
  void correct(const StateVec& shares, double beyond_rad, double sigma_rad);
  void move_by(const StateVec& change);

  HeadingSettings settings_;
  double heading_ = 0;
  double rate_ = 0;
  /// The skin's own way: its rotation vector beyond what is foretold at strength 1, frame H, rad. Where
  /// nothing is foretold, how it rests: +Y alone counts, for its turn about the vertical.
  Vec3 way_ = Vec3::Zero();
  /// How the sensor has crept on its skin since the calibration: a rotation vector, frame H, rad.
  Vec3 slip_ = Vec3::Zero();
  StateMat cov_ = StateMat::Zero();
  Vec3 smooth_rate_ = Vec3::Zero();
  double still_s_ = 0;
  double away_s_ = 0;          // How long the skin has been far to one side, ...
  double away_least_rad_ = 0;  // ... its smallest turn meanwhile, ...
  double away_way_rad_ = 0;    // ... and what of that was its own.
  // The running stretch.
  double stretch_s_ = 0;
  double n_ = 0;
  Quat from_ = Quat::Identity();
  Mat3 world_sum_ = Mat3::Zero();  // Of R_h.
  Vec3 turn_sum_ = Vec3::Zero();   // Of P's turns since the stretch began, ear's axes.
  Vec3 world_turn_sum_ = Vec3::Zero();
  double turn_turn_ = 0;
};

}  // namespace mien::imu
