#include "mien/virtual/imu/device_faults.h"

#include "mien/virtual/fault_table.h"

namespace mien::virt {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DeviceFaults, mount_rotation_deg, mount_position_mm, slip_deg_per_sqrt_min,
                                   adhesive_lag_ms, gyro_noise_dps_sqrt_hz, gyro_bias_dps,
                                   gyro_bias_walk_dps_sqrt_min, gyro_scale, gyro_range_dps,
                                   accel_noise_ug_sqrt_hz, accel_bias_mg, accel_scale, accel_range_g,
                                   magnetometer, mag_noise_ut, mag_hard_iron_ut, clock_offset_s,
                                   clock_drift_ppm, radio_delay_ms, radio_delay_min_ms, packet_loss,
                                   sensor_loss_per_hour)

Result<DeviceFaults> parse_faults(std::string_view text, const std::string& where) {
  // Clocks run forwards; ranges are those of the chip that the packets are made for.
  static constexpr FaultLimit kLimits[] = {{"packet_loss", 0, 1},
                                           {"clock_drift_ppm", 0, 1e4},
                                           {"gyro_range_dps", 1, 1024},
                                           {"accel_range_g", 1, 16}};
  return parse_fault_table<DeviceFaults>(text, where, kLimits);
}

}  // namespace mien::virt
