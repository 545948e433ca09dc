#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "mien/core/random.h"

namespace mien {

/// Brings `count` of the values, drawn, to the front (all are in a random order where count is their number):
/// a partial Fisher-Yates shuffle. More drawn of the same random numbers are those and others behind them.
template <typename T>
void draw_first(std::span<T> values, std::size_t count, Random& random) {
  for (std::size_t i = 0; i < std::min(count, values.size()); ++i)
    if (i + 1 < values.size()) std::swap(values[i], values[i + random.below(values.size() - i)]);
}

}  // namespace mien
