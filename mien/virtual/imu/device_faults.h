#pragma once

#include <array>
#include <string>
#include <string_view>

#include "mien/core/error.h"

namespace mien::virt {

/// What is wrong with a simulated IMU, as a rig file's [faults] table states it: one sigma unless said
/// otherwise, drawn once a sensor unless said to walk. The defaults are a perfect device.
struct DeviceFaults {
  double mount_rotation_deg =
      0;  ///< Sensor's axes against the skin: uniform angle up to this about any axis; 180: any turn.
  double mount_position_mm = 0;      ///< Off the site, along the skin (draw_placement).
  double slip_deg_per_sqrt_min = 0;  ///< Random walk of the mounting.
  std::array<double, 2>
      adhesive_lag_ms{};  ///< First-order lag between skin and sensor, uniform between these.
  double gyro_noise_dps_sqrt_hz = 0;
  double gyro_bias_dps = 0;
  double gyro_bias_walk_dps_sqrt_min = 0;
  double gyro_scale = 0;  ///< Relative.
  double gyro_range_dps = 1024;
  double accel_noise_ug_sqrt_hz = 0;
  double accel_bias_mg = 0;
  double accel_scale = 0;  ///< Relative.
  double accel_range_g = 8;
  bool magnetometer = false;
  double mag_noise_ut = 0;
  double mag_hard_iron_ut = 0;
  std::array<double, 2> clock_offset_s{};  ///< Device clock at the session's start, uniform.
  double clock_drift_ppm = 0;
  double radio_delay_ms = 0;  ///< Mean of the exponential part of the arrival delay.
  double radio_delay_min_ms = 0;
  double packet_loss = 0;           ///< Share of packets that never arrive, 0 to 1.
  double sensor_loss_per_hour = 0;  ///< Mean number of times an hour that a sensor falls silent for seconds.

  bool operator==(const DeviceFaults&) const = default;
};

/// Errors: malformed TOML, unknown keys; out_of_range: a number that is not finite, negative or above 1e6, a
/// share above 1, drift above 1e4 ppm, ranges outside 1 to 1024 deg/s and 1 to 16 g. `where` names the source
/// in messages.
[[nodiscard]] Result<DeviceFaults> parse_faults(std::string_view toml, const std::string& where);

}  // namespace mien::virt
