#include "mien/virtual/imu/device_faults.h"

#include <fmt/format.h>

#include "mien/virtual/fault_table.h"

namespace mien::virt {
namespace {

constexpr double kMostFaultDriftPpm = 1e4;  // A hundredth: clocks must run forwards.
/// Full scale of the chip that the packets are made for.
constexpr double kMostGyroRangeDps = 1024;
constexpr double kMostAccelRangeG = 16;

}  // namespace

Result<DeviceFaults> parse_faults(std::string_view text, const std::string& where) {
  DeviceFaults faults;
  const std::map<std::string_view, double*> numbers = {
      {"mount_rotation_deg", &faults.mount_rotation_deg},
      {"mount_position_mm", &faults.mount_position_mm},
      {"slip_deg_per_sqrt_min", &faults.slip_deg_per_sqrt_min},
      {"gyro_noise_dps_sqrt_hz", &faults.gyro_noise_dps_sqrt_hz},
      {"gyro_bias_dps", &faults.gyro_bias_dps},
      {"gyro_bias_walk_dps_sqrt_min", &faults.gyro_bias_walk_dps_sqrt_min},
      {"gyro_scale", &faults.gyro_scale},
      {"gyro_range_dps", &faults.gyro_range_dps},
      {"accel_noise_ug_sqrt_hz", &faults.accel_noise_ug_sqrt_hz},
      {"accel_bias_mg", &faults.accel_bias_mg},
      {"accel_scale", &faults.accel_scale},
      {"accel_range_g", &faults.accel_range_g},
      {"mag_noise_ut", &faults.mag_noise_ut},
      {"mag_hard_iron_ut", &faults.mag_hard_iron_ut},
      {"clock_drift_ppm", &faults.clock_drift_ppm},
      {"radio_delay_ms", &faults.radio_delay_ms},
      {"radio_delay_min_ms", &faults.radio_delay_min_ms},
      {"packet_loss", &faults.packet_loss},
      {"sensor_loss_per_hour", &faults.sensor_loss_per_hour},
  };
  const std::map<std::string_view, std::array<double, 2>*> ranges = {
      {"adhesive_lag_ms", &faults.adhesive_lag_ms}, {"clock_offset_s", &faults.clock_offset_s}};
  const FaultTable table{numbers, ranges, {{"magnetometer", &faults.magnetometer}}};
  MIEN_TRY(table.read(text, where));
  if (faults.packet_loss > 1)
    return fail(ErrorCode::out_of_range, "packet_loss is a share between 0 and 1", where);
  if (faults.clock_drift_ppm > kMostFaultDriftPpm)
    return fail(ErrorCode::out_of_range,
                fmt::format("clock_drift_ppm must be at most {:.0f}", kMostFaultDriftPpm), where);
  if (faults.gyro_range_dps < 1 || faults.gyro_range_dps > kMostGyroRangeDps)
    return fail(ErrorCode::out_of_range, fmt::format("gyro_range_dps must be 1 to {:.0f}", kMostGyroRangeDps),
                where);
  if (faults.accel_range_g < 1 || faults.accel_range_g > kMostAccelRangeG)
    return fail(ErrorCode::out_of_range, fmt::format("accel_range_g must be 1 to {:.0f}", kMostAccelRangeG),
                where);
  return faults;
}

}  // namespace mien::virt
