#include <algorithm>
#include <string>

#include "lab/imu/hours_study.h"

namespace mien::lab {
namespace {

using virt::DeviceFaults;

/// Devices without a fault, mounted at any angle.
DeviceFaults perfect() {
  return {.mount_rotation_deg = 180};
}

const std::array kHoursScenarios = std::to_array<HoursScenario>({
    {.name = "default", .description = "the rig's faults"},
    {.name = "perfect",
     .description = "devices without faults",
     .faults = [](const DeviceFaults&) { return perfect(); }},
    {.name = "slip",
     .description = "the rig's slip of the adhesive, and no other fault",
     .faults =
         [](const DeviceFaults& rig) {
           DeviceFaults faults = perfect();
           faults.slip_deg_per_sqrt_min = rig.slip_deg_per_sqrt_min;
           return faults;
         }},
    {.name = "bias",
     .description = "the gyroscopes' bias and its walk, and no other fault",
     .faults =
         [](const DeviceFaults& rig) {
           DeviceFaults faults = perfect();
           faults.gyro_bias_dps = rig.gyro_bias_dps;
           faults.gyro_bias_walk_dps_sqrt_min = rig.gyro_bias_walk_dps_sqrt_min;
           return faults;
         }},
    {.name = "scale",
     .description = "scale errors of gyroscopes and accelerometers, and no other fault",
     .faults =
         [](const DeviceFaults& rig) {
           DeviceFaults faults = perfect();
           faults.gyro_scale = rig.gyro_scale;
           faults.accel_scale = rig.accel_scale;
           return faults;
         }},
    {.name = "clocks",
     .description = "offset and drift of the devices' clocks, and no other fault",
     .faults =
         [](const DeviceFaults& rig) {
           DeviceFaults faults = perfect();
           faults.clock_offset_s = rig.clock_offset_s;
           faults.clock_drift_ppm = rig.clock_drift_ppm;
           return faults;
         }},
    {.name = "loss",
     .description = "delayed and lost packets, and no other fault",
     .faults =
         [](const DeviceFaults& rig) {
           DeviceFaults faults = perfect();
           faults.radio_delay_ms = rig.radio_delay_ms;
           faults.radio_delay_min_ms = rig.radio_delay_min_ms;
           faults.packet_loss = rig.packet_loss;
           faults.sensor_loss_per_hour = rig.sensor_loss_per_hour;
           return faults;
         }},
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
