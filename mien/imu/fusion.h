#pragma once

#include <array>
#include <cstdint>

#include "mien/core/rotation.h"

namespace mien::imu {

/// Settings of the orientation filter. Defaults follow Laidig and Seel 2023 where not said otherwise.
struct FusionSettings {
  /// Time constant of the inclination correction, s. Raising trusts the gyroscope longer: better under
  /// acceleration, worse under a gyroscope's bias.
  double tau_accel_s = 3.0;
  /// Time constant of the heading correction by the magnetometer, s.
  double tau_mag_s = 9.0;
  /// What a gyroscope's reading says. False: the rate at the sample's time (the middle of the reading, as our
  /// packets have it). True: the mean over the step that ends there, as of recordings that number their
  /// samples and tell no time.
  bool gyro_is_step_mean = false;
  /// Estimate the gyroscope's bias while moving (from the inclination correction) and at rest.
  bool motion_bias_estimation = true;
  bool rest_bias_estimation = true;
  /// Hold the heading against disturbed magnetic fields.
  bool mag_disturbance_rejection = true;

  /// Standard deviation of the bias at start, rad/s (1.5 deg/s; the paper's 0.5 is too sure for small sensors
  /// on skin; what lies beyond is learnt while the wearer holds still).
  double bias_sigma_init_rad_s = 0.0262;
  /// Time after which the bias, known exactly, is uncertain by 0.1 deg/s again, s. Raising follows warming up
  /// less.
  double bias_forgetting_s = 100.0;
  /// Largest error of the bias believed in motion, rad/s (5 deg/s).
  double bias_clip_rad_s = 0.0873;
  /// Largest bias believed, rad/s (15 deg/s), and the largest mean rate that may count as rest.
  double rest_bias_clip_rad_s = 0.26;
  /// Standard deviation of the converged bias while moving, rad/s (0.1 deg/s). Lowering follows motion more
  /// slowly.
  double bias_sigma_motion_rad_s = 0.001745;
  /// Weight of the vertical axis' bias, which motion does not show, against the others': holds it near where
  /// it was.
  double bias_vertical_forgetting = 0.0001;
  /// Standard deviation of the converged bias at rest, rad/s (0.03 deg/s).
  double bias_sigma_rest_rad_s = 0.000524;

  /// Rest is detected after this time, s, without a deviation from the low-passed rates beyond the two
  /// thresholds.
  double rest_min_s = 1.5;
  double rest_filter_tau_s = 0.5;
  /// What is compared with them is low-passed by this, s: a noisy sensor's single readings are no motion.
  double rest_noise_tau_s = 0.05;
  double rest_gyro_rad_s = 0.0349;  ///< 2 deg/s. Raising calls slow motion rest and learns it as bias.
  double rest_accel_m_s2 = 0.5;
  /// A resting rate farther than this (0.3 deg/s), and farther than three sigmas, from the known bias is slow
  /// motion, unless rest is expected.
  double rest_bias_tolerance_rad_s = 0.00524;

  /// Magnetometer: low-pass of norm and dip, s; of the reference, s; tolerances (share, rad); times, s; rate,
  /// rad/s.
  double mag_current_tau_s = 0.05;
  double mag_reference_tau_s = 20.0;
  double mag_norm_tolerance = 0.1;
  double mag_dip_tolerance_rad = 0.1745;
  double mag_new_s = 20.0;
  double mag_new_first_s = 5.0;
  double mag_new_min_gyro_rad_s = 0.349;
  double mag_min_undisturbed_s = 0.5;
  double mag_max_rejection_s = 60.0;
  double mag_rejection_factor = 2.0;

  /// A rate at the end of its sensor's range hides how fast the turn was; by this share of the range it may
  /// have been faster. Raising lets other readings put the heading right sooner.
  double clip_excess = 0.5;

  /// A gap between samples longer than this restarts the inclination correction, s: the held rate cannot be
  /// trusted.
  double max_gap_s = 0.25;
  /// How fast a sensor may have turned there and stopped again, unseen between the two ends of a gap, rad/s,
  /// one standard deviation (17 deg/s).
  double unseen_rate_rad_s = 0.3;
};

/// Second-order low-pass of N values with a free step: a Butterworth filter as a state-variable filter, whose
/// state stays meaningful when the time step changes. Its first tau seconds give the plain mean, so that it
/// starts without a transient. Source: Zavalishin 2012, "The Art of VA Filter Design", section 4
/// (topology-preserving transform).
template <int N>
class LowPass {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  /// `tau_s` as in VQF: cutoff sqrt(2) / (2 pi tau).
  explicit LowPass(double tau_s) : tau_s_(tau_s) {}

  const Vector& add(double dt_s, const Vector& value);
  [[nodiscard]] const Vector& value() const { return value_; }
  /// The next values count from the start again, the present one as the first.
  void restart() {
    elapsed_s_ = 0;
    count_ = 0;
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

/// Orientation of one IMU from gyroscope and accelerometer, and from a magnetometer where there is one, with
/// the gyroscope's bias estimated at rest and in motion.
///
/// q_world_sensor = q_delta * q_accel * q_gyro: strap-down integration; a slow correction of the inclination
/// by the low-passed specific force, filtered in the almost inertial frame that the integration gives, so
/// that motion cancels out of it; a turn about the vertical by the magnetometer. World: +Y up; +Z magnetic
/// north where fuse_mag is called, else any heading. Any step between samples, also an uneven one. A value
/// type: a copy is a snapshot. No allocation. About 0.4 us a sample. Source: Laidig and Seel 2023, "VQF",
/// doi:10.1016/j.inffus.2022.10.014; differences: docs/method/fusion.md.
class Fusion {
 public:
  explicit Fusion(const FusionSettings& settings = {});

  /// One sample. `dt_s` since the last, > 0; ignored for the first. Frame S. Numbers are finite.
  void add(double dt_s, const Vec3& gyro_rad_s, const Vec3& accel_m_s2);
  /// The magnetometer's reading of the sample just added; any unit, always the same one.
  void fuse_mag(const Vec3& mag);

  /// The board began anew: nothing stands but the gyroscope's bias, which is the chip's own.
  void restart();

  /// A wearer who was asked to hold still does: rest is then found sooner and with tolerance for a living
  /// body.
  void expect_rest(bool expected) { rest_expected_ = expected; }

  /// q_world_sensor. With fuse_mag its heading is magnetic.
  [[nodiscard]] Quat orientation() const;
  /// The last rate without its bias, frame S.
  [[nodiscard]] Vec3 rate_rad_s() const { return last_rate_; }
  [[nodiscard]] const Vec3& bias_rad_s() const { return bias_; }
  /// Standard deviation of the bias, the largest of any direction, about.
  [[nodiscard]] double bias_sigma_rad_s() const;
  [[nodiscard]] bool at_rest() const { return at_rest_; }
  /// Standard deviation that gaps and clipped rates have added to the orientation and that has not been
  /// corrected since, rad.
  [[nodiscard]] double gap_sigma_rad() const { return gap_sigma_; }
  /// How often a gap was so long that the inclination was begun anew (max_gap_s).
  [[nodiscard]] std::uint64_t restarts() const { return restarts_; }
  /// The magnetic field is not that of before; the heading is held by the gyroscope.
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
  double last_dt_s_ = 0;
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
  double clipped_rad_ = 0;  // What the running stretch of clipped rates may have hidden.
  MagState mag_;
};

}  // namespace mien::imu
