#pragma once

#include <algorithm>
#include <cstdint>

#include "mien/core/rotation.h"

namespace mien::imu {

/// Settings of the orientation filter. "VQF" marks a default of Laidig and Seel 2023
/// (doi:10.1016/j.inffus.2022.10.014); the others were chosen as docs/method/fusion.md and
/// docs/experiments/fusion.md say. Times, rates and standard deviations are above 0.
struct FusionSettings {
  /// Time constant of the accelerometer's low-pass, which corrects the inclination, s (VQF). Raising trusts
  /// the gyroscope longer: better under acceleration. Lowering: better under gyroscope bias.
  double tau_accel_s = 3.0;
  /// Time constant of the heading correction by the magnetometer, s (VQF). Raising: a steadier heading.
  /// Lowering: drift is corrected sooner, the heading is noisier.
  double tau_mag_s = 9.0;
  /// What a gyroscope sample is. False: the rate at the sample's time (the middle of the reading, as in our
  /// packets). True: the mean rate over the step that ends there, as in recordings that number their samples
  /// and have no times.
  bool gyro_is_step_mean = false;

  /// Gyroscope bias: a Kalman filter of three states, sensor frame.
  /// Initial standard deviation of each axis, rad/s (1.5 deg/s, docs/method/fusion.md: small chips; VQF has
  /// 0.5). Raising: large first biases are learnt sooner. Lowering: the bias is taken as nearer to 0 at
  /// first.
  double bias_sigma_init_rad_s = 0.0262;
  /// Process noise: the time in which an exactly known bias becomes uncertain by 0.1 deg/s, s (VQF). Raising
  /// (less noise): a warming chip is followed later. Lowering: the bias may change faster, and is noisier.
  double bias_forgetting_s = 100.0;
  /// Limit of the innovation in motion, rad/s an axis (5 deg/s; VQF has 2). Raising: outliers move the bias
  /// more. Lowering: a large bias is learnt more slowly.
  double bias_clip_rad_s = 0.0873;
  /// Limit of the bias itself, of the innovation at rest, and of the mean rate that may count as rest, rad/s
  /// an axis (15 deg/s: chips without factory calibration). Raising accepts worse chips. Lowering: slow turns
  /// pass for rest less often.
  double rest_bias_clip_rad_s = 0.26;
  /// Standard deviation to which the bias converges in motion, rad/s (0.1 deg/s, VQF); sets the measurement
  /// noise of inclination corrections. Raising: slower convergence, a steadier bias. Lowering: faster,
  /// noisier.
  double bias_sigma_motion_rad_s = 0.001745;
  /// Weight, against the horizontal components', of an artificial zero measurement of the vertical component,
  /// which motion does not make observable (VQF). Raising: that component decays to 0 sooner. Lowering: it
  /// keeps its last value longer.
  double bias_vertical_forgetting = 0.0001;
  /// Standard deviation to which the bias converges at rest, rad/s (0.03 deg/s, VQF). Raising: slower
  /// convergence, a steadier bias. Lowering: faster, noisier.
  double bias_sigma_rest_rad_s = 0.000524;

  /// Rest detection: all thresholds below must hold for this time, s (VQF); a third of it while rest is
  /// expected. Raising: rest is found later and more safely. Lowering: short pauses pass for rest.
  double rest_min_s = 1.5;
  /// Time constant of the low-passes whose values are the rest's mean rate and force, s (VQF). Raising: a
  /// smoother bias, rest found later. Lowering: slow motion passes for rest.
  double rest_filter_tau_s = 0.5;
  /// Time constant of the low-pass before the comparison with those means, s. Raising: noisier sensors can
  /// rest, and short jerks pass for rest. Lowering: single noisy samples count as motion.
  double rest_noise_tau_s = 0.05;
  /// Largest deviation from the mean rate, rad/s (2 deg/s, VQF), and from the mean specific force, m/s^2
  /// (VQF); both twice as large while rest is expected. Raising: slow motion passes for rest and is learnt as
  /// bias. Lowering: noise or sway prevents rest.
  double rest_gyro_rad_s = 0.0349;
  double rest_accel_m_s2 = 0.5;
  /// Gate on the mean rate at rest: it may differ from the bias by this, rad/s an axis (0.3 deg/s), or by
  /// three standard deviations of the bias if these are more; not applied while rest is expected. Raising:
  /// slow even turns are learnt as bias. Lowering: a bias that has changed is rejected.
  double rest_bias_tolerance_rad_s = 0.00524;

  /// Magnetic disturbance rejection; all defaults are VQF's.
  /// Time constant of the low-pass of the field's norm and dip, s. Raising: short disturbances are
  /// overlooked. Lowering: noise counts as disturbance.
  double mag_current_tau_s = 0.05;
  /// Time constant with which the reference norm and dip follow an undisturbed field, s. Raising: slow
  /// changes are followed less. Lowering: disturbances leak into the reference.
  double mag_reference_tau_s = 20.0;
  /// Gates about the reference: of the norm, as a share of it, and of the dip, rad (10 deg). Raising:
  /// stronger disturbances are let through. Lowering: more samples count as disturbed.
  double mag_norm_tolerance = 0.1;
  double mag_dip_tolerance_rad = 0.1745;
  /// How long another field must be homogeneous, while the sensor turns, to become the reference, s; the
  /// second applies while there is none. Raising: a changed field is accepted later. Lowering: sooner, a
  /// false one too.
  double mag_new_s = 20.0;
  double mag_new_first_s = 5.0;
  /// Least rate at which that time counts, rad/s (20 deg/s). Raising: faster turning is needed. Lowering:
  /// slow turning suffices, which tells a homogeneous field less surely.
  double mag_new_min_gyro_rad_s = 0.349;
  /// How long the field must be within the gates to count as undisturbed, s. Raising: corrections resume
  /// later after a disturbance. Lowering: sooner.
  double mag_min_undisturbed_s = 0.5;
  /// Full rejection of a disturbed field lasts this long, s; then it corrects at reduced gain. Raising: it is
  /// ignored longer. Lowering: it is followed sooner.
  double mag_max_rejection_s = 60.0;
  /// Divisor of the gain after that time, and the rate at which the time is regained while undisturbed.
  /// Raising: less gain, faster recovery. Lowering: more gain, slower recovery.
  double mag_rejection_factor = 2.0;

  /// Clipping: how far, as a share of the range, the true rate may lie beyond a sample at the range's end
  /// (docs/experiments/fusion.md, clipped gyroscopes). Raising: clipped samples make the orientation less
  /// certain, so that heading measurements correct it sooner. Lowering: clipped rates are trusted more.
  double clip_excess = 0.5;

  /// Longest gap, s, that is bridged by the rates at its ends; after a longer one the inclination is begun
  /// anew from gravity, and from those rates as far as they are certain. (A step of more than 2.5 times the
  /// one before is a gap.) Raising: longer gaps are bridged, inclinations may be wrong. Lowering:
  /// inclinations are begun anew more often.
  double max_gap_s = 0.25;
  /// Standard deviation of the mean rate within a gap that its two ends do not show, rad/s (17 deg/s); of
  /// gaps below a tenth of a second a part (docs/method/fusion.md).
  /// Raising: gaps make a sensor less certain, and it is left out sooner. Lowering: gaps are trusted more.
  double unseen_rate_rad_s = 0.3;
};

/// Second-order Butterworth low-pass of N values for variable time steps: a state-variable filter, whose
/// state does not depend on the step. During its first tau seconds it gives the plain mean, which avoids a
/// start-up transient (VQF). Source: Zavalishin 2012, "The Art of VA Filter Design", section 4
/// (topology-preserving transform).
template <int N>
class LowPass {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  /// `tau_s` as in VQF: cutoff sqrt(2) / (2 pi tau).
  explicit LowPass(double tau_s) : tau_s_(tau_s) {}

  const Vector& add(double dt_s, const Vector& value);
  [[nodiscard]] const Vector& value() const { return value_; }
  /// Begins the initial averaging again. The present value counts for so many of the next ones, at most for
  /// those that it is of.
  void restart(double values = 0) {
    elapsed_s_ = 0;
    count_ = std::min(count_, values);
    sum_ = count_ * value_;
    low_ = value_;
    band_.setZero();
  }

 private:
  double tau_s_;
  double elapsed_s_ = 0;
  double count_ = 0;
  double dt_s_ = -1;  // Of the coefficients.
  double a1_ = 0, a2_ = 0, a3_ = 0;
  Vector sum_ = Vector::Zero();
  Vector band_ = Vector::Zero();
  Vector low_ = Vector::Zero();
  Vector value_ = Vector::Zero();
};

/// Orientation of one IMU from gyroscope and accelerometer, and a magnetometer where there is one, with
/// online estimation of the gyroscope's bias at rest and in motion.
///
/// q_world_sensor = q_delta * q_accel * q_gyro: strap-down integration; inclination correction by the
/// specific force, low-passed in the almost inertial frame of the integration, where motion averages out;
/// heading correction about the vertical by the magnetometer. World: +Y up; +Z magnetic north where fuse_mag
/// is called, else an arbitrary heading. Steps between samples may vary. A value type: a copy is a snapshot.
/// No allocation. About 0.4 us a sample. Source: Laidig and Seel 2023, "VQF",
/// doi:10.1016/j.inffus.2022.10.014; differences: docs/method/fusion.md.
class Fusion {
 public:
  explicit Fusion(const FusionSettings& settings = {});

  /// One sample, frame S: angular rate (bias included) and specific force (+g upward at rest). `dt_s`: since
  /// the last sample, > 0; ignored for the first. All finite.
  void add(double dt_s, const Vec3& gyro_rad_s, const Vec3& accel_m_s2);
  /// The magnetometer's reading of the sample just added, frame S; any unit, always the same one.
  void fuse_mag(const Vec3& mag);

  /// The board restarted: resets everything but the gyroscope's bias, which belongs to the chip.
  void restart();

  /// Whether a wearer was asked to hold still: rest is then detected in a third of the time, at twice the
  /// tolerance, and at any rate within rest_bias_clip_rad_s.
  void expect_rest(bool expected) { rest_expected_ = expected; }
  [[nodiscard]] bool rest_expected() const { return rest_expected_; }
  /// Whether the sensor sits on a living head, which sways by 0.1 to 0.3 deg/s: rest then tells no bias
  /// unless it is expected, and no vertical bias is learnt from sway.
  void set_on_skin(bool on_skin) { on_skin_ = on_skin; }
  [[nodiscard]] bool on_skin() const { return on_skin_; }

  /// q_world_sensor. With fuse_mag its heading is magnetic.
  [[nodiscard]] Quat orientation() const;
  /// The last rate without its bias, frame S.
  [[nodiscard]] Vec3 rate_rad_s() const { return last_rate_; }
  [[nodiscard]] const Vec3& bias_rad_s() const { return bias_; }
  /// Standard deviation of the bias: the largest of the three axes', rad/s.
  [[nodiscard]] double bias_sigma_rad_s() const;
  [[nodiscard]] bool at_rest() const { return at_rest_; }
  /// Standard deviation that gaps and clipped rates have added to the orientation since the start or
  /// restart(), rad. Only grows meanwhile: callers take its increments.
  [[nodiscard]] double gap_sigma_rad() const { return gap_sigma_; }
  /// How often the inclination was begun anew: gaps beyond max_gap_s, and restart().
  [[nodiscard]] std::uint64_t restarts() const { return restarts_; }
  /// Whether the magnetic field is outside the gates about its reference; true before there is one.
  [[nodiscard]] bool mag_disturbed() const { return mag_.disturbed; }

 private:
  void detect_rest(double dt_s, const Vec3& gyro, const Vec3& accel);
  void correct_inclination(double dt_s, const Vec3& accel);
  void estimate_bias(double dt_s, const Mat3& rotation, const Vec3& error_up);

  struct MagState {
    LowPass<2> current;  // Norm, dip.
    double norm = 0;
    double dip = 0;
    double reference_norm = 0;
    double reference_dip = 0;
    double candidate_norm = -1;
    double candidate_dip = 0;
    double undisturbed_s = 0;
    double candidate_s = 0;
    double rejected_s = 0;
    double start_gain = 1;
    bool disturbed = true;
  };

  FusionSettings settings_;
  bool started_ = false;
  bool rest_expected_ = false;
  bool on_skin_ = false;
  double last_dt_s_ = 0;  // The last step that was no gap.
  double last_gap_s_ = 0;
  int alike_gaps_ = 0;  // In a row.
  Quat q_gyro_ = Quat::Identity();
  Quat q_accel_ = Quat::Identity();
  double heading_ = 0;  // Delta, about the vertical.
  Vec3 last_raw_ = Vec3::Zero();
  Vec3 last_rate_ = Vec3::Zero();
  LowPass<3> force_;
  LowPass<3> rest_gyro_;
  LowPass<3> rest_accel_;
  LowPass<3> quick_gyro_;
  LowPass<3> quick_accel_;
  double rest_s_ = 0;
  bool at_rest_ = false;
  LowPass<9> rotation_;      // Rows of R, low-passed like the force.
  LowPass<2> rotated_bias_;  // Horizontal parts of R b.
  Vec3 bias_ = Vec3::Zero();
  Mat3 bias_cov_;
  double gap_sigma_ = 0;
  std::uint64_t restarts_ = 0;
  double clipped_rad_ = 0;  // Possible angle hidden by the current run of clipped samples.
  MagState mag_;
};

}  // namespace mien::imu
