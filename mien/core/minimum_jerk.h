#pragma once

namespace mien {

/// From 0 to 1 with no velocity and no acceleration at either end (minimum jerk: Flash and Hogan 1985,
/// doi:10.1523/JNEUROSCI.05-07-01688.1985); held outside [0, 1].
[[nodiscard]] constexpr double minimum_jerk(double u) {
  if (u <= 0) return 0;
  if (u >= 1) return 1;
  return u * u * u * (10 + u * (6 * u - 15));
}

/// Time course of a movement there and back: rise, hold, fall, with minimum-jerk slopes. Seconds.
struct Envelope {
  double begin_s = 0;
  double rise_s = 0.2;
  double hold_s = 0;
  double fall_s = 0.3;

  [[nodiscard]] double end_s() const { return begin_s + rise_s + hold_s + fall_s; }
  /// 0 to 1.
  [[nodiscard]] double at(double time_s) const {
    const double t = time_s - begin_s;
    if (t < rise_s) return minimum_jerk(t / rise_s);
    return 1 - minimum_jerk((t - rise_s - hold_s) / fall_s);
  }
};

}  // namespace mien
