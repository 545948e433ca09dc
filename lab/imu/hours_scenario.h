#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "mien/core/error.h"
#include "mien/virtual/imu/device_faults.h"

namespace mien::lab {

/// What happens to one face sensor, which is drawn for each person. Minutes after the motion's start.
struct HoursEvent {
  double begin_min = 0;  ///< 0: nothing but what `restarts_min` says.
  double end_min = 0;
  double turn_deg = 0;     ///< It is turned on its skin by so much, about any axis, evenly from begin to end.
  bool silent = false;     ///< Nothing is heard of it from begin to end.
  double heading_deg = 0;  ///< Of a silent one: how far off the heading is that is integrated over the gap.
  double shift_mm = 0;     ///< Of a silent one: it is put on elsewhere, one sigma an axis.
  std::array<double, 2> restarts_min{};  ///< Its board begins anew then; 0: it does not.

  /// When all of it has happened; 0: nothing happens.
  [[nodiscard]] double last_min() const {
    return std::max({begin_min, end_min, restarts_min[0], restarts_min[1]});
  }
};

/// What may go wrong in a session of hours: devices' faults, how the head moves, and what befalls a sensor.
struct HoursScenario {
  std::string_view name;
  std::string_view description;                                           ///< For people: a phrase.
  virt::DeviceFaults (*faults)(const virt::DeviceFaults& rig) = nullptr;  ///< None: those of the rig.
  bool head_still = false;  ///< After the prologue the head does not turn.
  HoursEvent event;
};

/// All of them; "default" first.
[[nodiscard]] std::span<const HoursScenario> hours_scenarios();
/// Errors: not_found, listing the names.
[[nodiscard]] Result<HoursScenario> find_hours_scenario(std::string_view name);

}  // namespace mien::lab
