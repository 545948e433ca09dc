#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "lab/imu/hours_study.h"

namespace mien::lab {
namespace {

using virt::DeviceFaults;

/// The rig's own of these faults on devices that have no other, mounted at any angle.
template <auto... kMembers>
DeviceFaults only(const DeviceFaults& rig) {
  DeviceFaults faults{.mount_rotation_deg = 180};
  ((faults.*kMembers = rig.*kMembers), ...);
  return faults;
}

const std::array kHoursScenarios = std::to_array<HoursScenario>({
    {.name = "default", .description = "the rig's faults"},
    {.name = "perfect", .description = "devices without faults", .faults = only<>},
    {.name = "slip",
     .description = "the rig's slip of the adhesive, and no other fault",
     .faults = only<&DeviceFaults::slip_deg_per_sqrt_min>},
    {.name = "bias",
     .description = "the gyroscopes' bias and its walk, and no other fault",
     .faults = only<&DeviceFaults::gyro_bias_dps, &DeviceFaults::gyro_bias_walk_dps_sqrt_min>},
    {.name = "scale",
     .description = "scale errors of gyroscopes and accelerometers, and no other fault",
     .faults = only<&DeviceFaults::gyro_scale, &DeviceFaults::accel_scale>},
    {.name = "clocks",
     .description = "offset and drift of the devices' clocks, and no other fault",
     .faults = only<&DeviceFaults::clock_offset_s, &DeviceFaults::clock_drift_ppm>},
    {.name = "loss",
     .description = "delayed and lost packets, and no other fault",
     .faults = only<&DeviceFaults::radio_delay_ms, &DeviceFaults::radio_delay_min_ms,
                    &DeviceFaults::packet_loss, &DeviceFaults::sensor_loss_per_hour>},
    {.name = "slip_x3",
     .description = "the rig's faults, with three times its slip",
     .faults =
         [](const DeviceFaults& rig) {
           DeviceFaults faults = rig;
           faults.slip_deg_per_sqrt_min *= 3;
           return faults;
         }},
    {.name = "slide",
     .description = "one sensor slides by 10 degrees from minute 10 to 70",
     .event = {.begin_min = 10, .end_min = 70, .turn_deg = 10}},
    {.name = "jump",
     .description = "one sensor jumps by 8 degrees in minute 40",
     .event = {.begin_min = 40, .end_min = 40, .turn_deg = 8}},
    {.name = "gap",
     .description = "one sensor is silent for 5 seconds in minute 40, and its heading 20 degrees off then",
     .event = {.begin_min = 40, .end_min = 40 + 5.0 / 60, .silent = true, .heading_deg = 20}},
    {.name = "put_on_again",
     .description = "one sensor is silent for minute 40, and worn elsewhere then, turned by 25 degrees",
     .event = {.begin_min = 40, .end_min = 41, .turn_deg = 25, .silent = true, .shift_mm = 3}},
    {.name = "still_head", .description = "the head does not turn after the calibration", .head_still = true},
    {.name = "restart",
     .description = "one sensor's board restarts in minutes 40 and 80",
     .event = {.restarts_min = {40, 80}}},
});

}  // namespace

std::span<const HoursScenario> hours_scenarios() {
  return kHoursScenarios;
}

Result<HoursScenario> find_hours_scenario(std::string_view name) {
  const auto found = std::ranges::find(kHoursScenarios, name, &HoursScenario::name);
  if (found != kHoursScenarios.end()) return *found;
  std::string names;
  for (const HoursScenario& scenario : kHoursScenarios)
    names += (names.empty() ? "" : ", ") + std::string(scenario.name);
  return fail(ErrorCode::not_found, "there is no such scenario", std::string(name), "there are " + names);
}

}  // namespace mien::lab
