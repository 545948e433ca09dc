#pragma once

#include <array>

#include "mien/core/random.h"
#include "mien/core/time.h"

namespace mien::virt {

/// A device's clock against true time: device = offset + rate * true.
struct VirtualClock {
  double offset_s = 0;
  double rate = 1;  ///< 1 + drift.

  /// One that shows a time of this range at true time 0, and runs so many ppm (one sigma) too fast or slow.
  [[nodiscard]] static VirtualClock drawn(const std::array<double, 2>& offset_s, double drift_ppm,
                                          Random random) {
    VirtualClock clock;
    clock.offset_s = random.uniform(offset_s[0], offset_s[1]);
    clock.rate = 1 + 1e-6 * random.normal(0, drift_ppm);
    return clock;
  }

  [[nodiscard]] DeviceTime device(double true_s) const {
    return DeviceTime(from_seconds(offset_s + rate * true_s));
  }
  [[nodiscard]] double true_s(DeviceTime device_time) const {
    return (to_seconds(device_time.time_since_epoch()) - offset_s) / rate;
  }
};

}  // namespace mien::virt
