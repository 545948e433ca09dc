#pragma once

#include <cstddef>
#include <vector>

#include "mien/core/rotation.h"

namespace mien::imu {

/// Scale of a Kalman filter's process noise for states of one kind, a vector a sensor: cheaper gyroscopes and
/// softer adhesives walk faster than settings expect. Innovation-based (R. Mehra, IEEE Transactions on
/// Automatic Control 15, 1970): if the process noise is right, the expected square of a state's summed
/// corrections equals the sum of its variance's reductions. The ratio's median over sensors is followed, so
/// that held expressions and accidents of a few sensors do not move it. Thread: one at a time. No allocation
/// after construction. Method: docs/method/fusion.md (drift); figures: docs/experiments/hours.md.
class WalkScale {
 public:
  /// `window_s`: corrections within this time are summed. Raising: the ratio scatters less. Lowering: faster
  /// walks are found sooner. `usual_ratio`: the ratio where the walk is as expected, below 1 where the filter
  /// takes its measurements for more correlated than they are. Raising: the scale stays at 1 for longer.
  /// Lowering: usual walks are scaled up, too.
  WalkScale(std::size_t sensors, double window_s, double usual_ratio);

  /// Begins anew with a scale of 1.
  void start();
  /// One correction of a sensor's state. `by`: its change. `expected`: by how much it lowers the state's
  /// variance, the sum over axes; unit: the state's, squared.
  void add(std::size_t sensor, const Vec3& by, double expected);
  /// Time passes. Returns by which factor the scale has changed: 1 but at a window's end, and where fewer
  /// than three sensors were corrected in it.
  double advance(double dt_s);
  /// The walk's variance over the expected one, 1 to 16. It scatters by a factor of two.
  [[nodiscard]] double variance_factor() const { return factor_; }

 private:
  double window_s_, usual_ratio_;
  // By sensor, in this window.
  std::vector<Vec3> moved_;
  std::vector<double> expected_;
  std::vector<double> ratios_;  // A member, so that nothing is allocated.
  double passed_s_ = 0;
  double factor_ = 1;
};

}  // namespace mien::imu
