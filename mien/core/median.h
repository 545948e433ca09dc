#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace mien {

/// The median of at least one value, none of them NaN; of an even number of values the greater of the middle
/// two, so that it is one of them. O(N).
template <class T>
[[nodiscard]] T upper_median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace mien
