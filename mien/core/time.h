#pragma once

#include <chrono>
#include <cstdint>

namespace mien {

/// All durations inside are whole nanoseconds: sums of them are exact and replay gives the same bits.
using Duration = std::chrono::nanoseconds;

/// The clock of one device, from its power-on. Two devices' times mean nothing to each other; only
/// sensor::ClockModel brings them together.
struct DeviceClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  using time_point = std::chrono::time_point<DeviceClock>;
};

/// The steady clock of the machine that runs the session. In a take it counts from the session's start.
struct HostClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  using time_point = std::chrono::time_point<HostClock>;
};

using DeviceTime = DeviceClock::time_point;
using HostTime = HostClock::time_point;

/// Seconds as a double, for filters and for people. Exact to a nanosecond over 100 days.
[[nodiscard]] constexpr double to_seconds(Duration d) {
  return static_cast<double>(d.count()) * 1e-9;
}
/// The nearest nanosecond; `seconds` within +-9e9.
[[nodiscard]] constexpr Duration from_seconds(double seconds) {
  return Duration{static_cast<std::int64_t>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5))};
}

/// The output grid: 60 frames a second.
inline constexpr double kFrameRateHz = 60.0;
/// Time of frame `index` on the output grid, from the grid's origin; rounded once, so frames never drift.
[[nodiscard]] constexpr Duration frame_offset(std::int64_t index) {
  return Duration{(index * 1'000'000'000 + (index < 0 ? -30 : 30)) / 60};
}

}  // namespace mien
