#pragma once

namespace mien {

/// From 0 to 1 with no velocity and no acceleration at either end (minimum jerk: Flash and Hogan 1985,
/// doi:10.1523/JNEUROSCI.05-07-01688.1985); held outside [0, 1].
[[nodiscard]] constexpr double minimum_jerk(double u) {
  if (u <= 0) return 0;
  if (u >= 1) return 1;
  return u * u * u * (10 + u * (6 * u - 15));
}

}  // namespace mien
