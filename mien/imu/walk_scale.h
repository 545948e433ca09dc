#pragma once

#include <cstddef>
#include <vector>

#include "mien/core/rotation.h"

namespace mien::imu {

/// How fast a Kalman filter's states of a kind walk, one vector a sensor, against the random walk that its
/// settings expect: cheaper gyroscopes, softer adhesives. Innovation-based: the corrections of a state over a
/// time have, squared, the mean by which they lower its variance. Where they are larger at most sensors the
/// states walk faster. Holds and accidents of a few sensors do not move the median over sensors. Thread: one
/// at a time. No allocation after construction. Method and figures: docs/method/fusion.md (drift),
/// docs/experiments/hours.md.
class WalkScale {
 public:
  /// `window_s`: corrections within this time are taken together. Raising: those of skin that is held count
  /// for less. Lowering: faster walks are found sooner.
  WalkScale(std::size_t sensors, double window_s);

  /// Begins anew: the walk is as expected.
  void start();
  /// One correction of a sensor's state. `by`: its change. `expected`: by how much it lowers the state's
  /// variance, the sum over axes; unit: the state's, squared.
  void add(std::size_t sensor, const Vec3& by, double expected);
  /// Time passes. Returns by which factor the walk's variance has changed; 1 but at a window's end.
  double advance(double dt_s);
  /// The walk's variance over its expected one, 1 to 16.
  [[nodiscard]] double variance_factor() const { return factor_; }

 private:
  double window_s_;
  // By sensor, in this window.
  std::vector<Vec3> moved_;
  std::vector<double> expected_;
  std::vector<double> ratios_;  // A member, so that nothing is allocated.
  double passed_s_ = 0;
  double factor_ = 1;
};

}  // namespace mien::imu
