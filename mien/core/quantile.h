#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace mien {

/// The quantile `q` (0 to 1) of sorted values, linear between the two nearest ranks (Hyndman and Fan 1996,
/// type 7, doi:10.1080/00031305.1996.10473566). At least one value.
[[nodiscard]] inline double quantile_of_sorted(std::span<const double> sorted, double q) {
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace mien
