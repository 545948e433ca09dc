#pragma once

#include <algorithm>

namespace mien {

/// The cubic 3u^2 - 2u^3: from 0 to 1 as u goes from 0 to 1, beginning and ending at rest; held outside. Its
/// steepest slope is 1.5.
template <class T>
[[nodiscard]] constexpr T smoothstep(T u) {
  const T t = std::clamp(u, T(0), T(1));
  return t * t * (3 - 2 * t);
}

/// The same as x goes from `edge0` to `edge1`, either of which may be the greater.
[[nodiscard]] constexpr double smoothstep(double edge0, double edge1, double x) {
  return smoothstep((x - edge0) / (edge1 - edge0));
}
[[nodiscard]] constexpr float smoothstep(float edge0, float edge1, float x) {
  return smoothstep((x - edge0) / (edge1 - edge0));
}

}  // namespace mien
