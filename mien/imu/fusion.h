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
  /// Estimate the gyroscope's bias while moving (from the inclination correction) and at rest.
  bool motion_bias_estimation = true;
  bool rest_bias_estimation = true;
  /// Hold the heading against disturbed magnetic fields.
  bool mag_disturbance_rejection = true;

  /// Standard deviation of the bias at start, rad/s (1.5 deg/s; the paper's 0.5 is too sure for small sensors
  /// on skin).
  double bias_sigma_init_rad_s = 0.0262;
  /// Time after which the bias, known exactly, is uncertain by 0.1 deg/s again, s. Raising follows warming up
  /// less.
  double bias_forgetting_s = 100.0;
  /// Largest bias believed, rad/s (5 deg/s), and the largest mean rate that may count as rest.
  double bias_clip_rad_s = 0.0873;
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
  double rest_gyro_rad_s = 0.0349;  ///< 2 deg/s. Raising calls slow motion rest and learns it as bias.
  double rest_accel_m_s2 = 0.5;

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

  /// A gap between samples longer than this restarts the inclination correction, s: the held rate cannot be
  /// trusted.
  double max_gap_s = 0.25;
};

}  // namespace mien::imu
