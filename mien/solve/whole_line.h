#pragma once

#include <algorithm>
#include <chrono>

#include "mien/sensor/clock_model.h"

namespace mien::solve {

/// Arrivals and times of one device over a whole take, as a line under all of them.
class WholeLine {
 public:
  /// `span`: how long the take is.
  explicit WholeLine(Duration span)
      : clock_({.stretch = std::max<Duration>(std::chrono::seconds(1), span / 60), .max_rate = 500e-6}) {}
  void add(DeviceTime time, HostTime arrival) { clock_.add(time, arrival); }
  [[nodiscard]] const sensor::ClockModel& clock() const { return clock_; }

 private:
  sensor::ClockModel clock_;
};

}  // namespace mien::solve
