#include "mien/virtual/device_faults.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>

#include "mien/core/toml.h"

namespace mien::virt {
namespace {

/// Beyond this no fault means anything in its unit, and times would leave what a packet can say.
constexpr double kMost = 1e6;
constexpr double kMostDriftPpm = 1e4;  // A hundredth: clocks must run forwards.
/// Full scale of the chip that the packets are made for.
constexpr double kMostGyroRangeDps = 1024;
constexpr double kMostAccelRangeG = 16;

}  // namespace

Result<DeviceFaults> parse_faults(std::string_view text, const std::string& where) {
  MIEN_TRY_ASSIGN(const toml::table table, parse_toml(text, where + ", [faults]"));
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
  const auto number = [&](const toml::node& node, std::string_view key) -> Result<double> {
    // value() alone would take true for a number.
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value) return fail(ErrorCode::malformed, fmt::format("{} must be a number", key), where);
    if (!std::isfinite(*value) || *value < 0)
      return fail(ErrorCode::out_of_range, fmt::format("{} must be finite and not negative", key), where);
    if (*value > kMost)
      return fail(ErrorCode::out_of_range, fmt::format("{} must be at most {:.0f}", key, kMost), where);
    return *value;
  };
  for (const auto& [name, node] : table) {
    const std::string_view key = name.str();
    if (const auto found = numbers.find(key); found != numbers.end()) {
      MIEN_TRY_ASSIGN(*found->second, number(node, key));
    } else if (const auto range = ranges.find(key); range != ranges.end()) {
      const toml::array* pair = node.as_array();
      if (pair == nullptr || pair->size() != 2)
        return fail(ErrorCode::malformed, fmt::format("{} must be [least, most]", key), where);
      for (std::size_t i = 0; i < 2; ++i) {
        MIEN_TRY_ASSIGN((*range->second)[i], number((*pair)[i], key));
      }
      if ((*range->second)[1] < (*range->second)[0])
        return fail(ErrorCode::out_of_range, fmt::format("{}: the most is less than the least", key), where);
    } else if (key == "magnetometer") {
      if (!node.is_boolean()) return fail(ErrorCode::malformed, "magnetometer must be true or false", where);
      faults.magnetometer = *node.value<bool>();
    } else {
      return fail(ErrorCode::malformed, fmt::format("there is no fault named {}", key), where);
    }
  }
  if (faults.packet_loss > 1)
    return fail(ErrorCode::out_of_range, "packet_loss is a share between 0 and 1", where);
  if (faults.clock_drift_ppm > kMostDriftPpm)
    return fail(ErrorCode::out_of_range, fmt::format("clock_drift_ppm must be at most {:.0f}", kMostDriftPpm),
                where);
  if (faults.gyro_range_dps < 1 || faults.gyro_range_dps > kMostGyroRangeDps)
    return fail(ErrorCode::out_of_range, fmt::format("gyro_range_dps must be 1 to {:.0f}", kMostGyroRangeDps),
                where);
  if (faults.accel_range_g < 1 || faults.accel_range_g > kMostAccelRangeG)
    return fail(ErrorCode::out_of_range, fmt::format("accel_range_g must be 1 to {:.0f}", kMostAccelRangeG),
                where);
  return faults;
}

}  // namespace mien::virt
