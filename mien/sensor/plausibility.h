#pragma once

#include <cstdint>
#include <optional>

#include "mien/core/time.h"
#include "mien/sensor/sample.h"

namespace mien::sensor {

/// Whether what a sender gives can come from a sensor: over each second of host time its clock goes as the
/// host's does, and where it measures specific force, that is gravity's on average. Who forges readings by
/// the book passes; who sends noise, zeros, or a clock that leaps or stands does not. A pure function of the
/// calls. No allocation.
class Plausibility {
 public:
  /// Of host time; what is judged at once. Longer: a radio's delays matter less, and the answer comes later.
  static constexpr Duration kWindow = std::chrono::seconds(1);
  /// Share by which the sender's clock may go otherwise than the host's within a window: arrivals are delayed
  /// by up to a tenth of a second. Higher: clocks that run away pass.
  static constexpr double kClockTolerance = 0.25;
  /// Share by which the mean size of the specific force may miss gravity's: walking and nodding stay below
  /// 0.1, a run comes near 0.3.
  static constexpr double kGravityTolerance = 0.3;

  /// A sample as it arrives.
  void add(HostTime arrival, const Sample& sample);
  /// The last two windows were those of a sensor.
  [[nodiscard]] bool is_plausible() const { return windows_ >= 2 && (bad_ & 0b11U) == 0; }
  /// Two of the last four were not.
  [[nodiscard]] bool is_implausible() const;

 private:
  [[nodiscard]] bool judge() const;

  std::optional<HostTime> begun_;  // The present window: its first sample, ...
  DeviceTime begun_device_;
  HostTime newest_;  // ... its last, ...
  DeviceTime newest_device_;
  double force_sum_m_s2_ = 0;  // ... and what was measured meanwhile.
  int forces_ = 0;
  int windows_ = 0;        // Judged so far.
  std::uint32_t bad_ = 0;  // A bit a window, the newest lowest.
};

}  // namespace mien::sensor
