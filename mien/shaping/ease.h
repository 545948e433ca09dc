#pragma once

#include <algorithm>

namespace mien::shaping {

/// From 0 to 1 as u goes from 0 to 1, beginning and ending at rest; held outside. The steepest is 1.5.
[[nodiscard]] constexpr double ease(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

}  // namespace mien::shaping
