#pragma once

#include "mien/core/time.h"

namespace mien::virt {

/// A device's clock against true time: device = offset + rate * true.
struct VirtualClock {
  double offset_s = 0;
  double rate = 1;  ///< 1 + drift.

  [[nodiscard]] DeviceTime device(double true_s) const {
    return DeviceTime(from_seconds(offset_s + rate * true_s));
  }
  [[nodiscard]] double true_s(DeviceTime device_time) const {
    return (to_seconds(device_time.time_since_epoch()) - offset_s) / rate;
  }
};

}  // namespace mien::virt
