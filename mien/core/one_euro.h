#pragma once

#include "mien/core/rotation.h"
#include "mien/core/time.h"

namespace mien {

/// How strongly a signal is smoothed: little when it moves fast, much when it rests.
struct OneEuroSettings {
  /// Hz, > 0: the cutoff at rest. Lowering removes more tremor and adds delay: 1 / (2 pi cutoff), 159 ms at
  /// 1 Hz, 16 ms at 10 Hz.
  double min_cutoff_hz = 1;
  /// Hz per unit a second, >= 0: how fast the cutoff rises with the signal's speed. Raising takes the delay
  /// out of quick movement and lets its noise through.
  double beta = 0;
  /// Hz, > 0: the cutoff at which the speed itself is smoothed; without effect while beta is 0. Raising lets
  /// the filter open sooner when a movement begins, and open with noise at rest; lowering opens and closes it
  /// later. The authors' value; rarely worth changing.
  double derivative_cutoff_hz = 1;
  bool operator==(const OneEuroSettings&) const = default;
};

/// The share of the way that a first-order low pass goes to a new value after `step_s` seconds, in [0, 1):
/// 1 / (1 + 1 / (2 pi cutoff_hz step_s)). 0 when the step or the cutoff is not above 0.
[[nodiscard]] double low_pass_share(double cutoff_hz, double step_s);

/// The One Euro filter on sample time, whatever the rate: a first-order low pass whose cutoff follows the
/// signal's smoothed speed. The speed is taken against the last *filtered* value, as the authors' code does
/// since 2023. A gap in time needs nothing: the longer the step, the closer the answer to the new value.
/// A value that is not finite, and one whose time does not lie after the last, change nothing.
/// Deterministic, no allocation. Source: Casiez, Roussel and Vogel 2012, doi:10.1145/2207676.2208639.
class OneEuro {
 public:
  OneEuro() = default;
  explicit OneEuro(const OneEuroSettings& settings) : settings_(settings) {}

  /// The filtered value at `time`; the first value goes through as it is. 0 while there was none.
  double filter(DeviceTime time, double value);
  /// The last answer; 0 before the first.
  [[nodiscard]] double value() const { return value_; }
  /// Keeps what is filtered so far.
  void set(const OneEuroSettings& settings) { settings_ = settings; }
  /// The next value goes through as it is.
  void reset() { *this = OneEuro(settings_); }

 private:
  OneEuroSettings settings_;
  bool begun_ = false;
  DeviceTime time_;
  double value_ = 0;
  double speed_ = 0;  // Smoothed, a second.
};

/// The same for rotations: goes the share of the way along the shortest turn; speed in rad/s. Unit
/// quaternions; one that is not finite or far from unit changes nothing.
class OneEuroRotation {
 public:
  OneEuroRotation() = default;
  explicit OneEuroRotation(const OneEuroSettings& settings) : settings_(settings) {}

  Quat filter(DeviceTime time, const Quat& value);
  [[nodiscard]] const Quat& value() const { return value_; }
  void set(const OneEuroSettings& settings) { settings_ = settings; }
  void reset() { *this = OneEuroRotation(settings_); }

 private:
  OneEuroSettings settings_;
  bool begun_ = false;
  DeviceTime time_;
  Quat value_ = Quat::Identity();
  Vec3 speed_ = Vec3::Zero();
};

}  // namespace mien
