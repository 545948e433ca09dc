#pragma once

#include <cstdint>
#include <vector>

#include "mien/core/random.h"

namespace mien::model {

/// From -1 to 1, evenly drawn.
inline std::vector<float> numbers(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<float> values(count);
  for (float& v : values) v = static_cast<float>(random.uniform(-1, 1));
  return values;
}

}  // namespace mien::model
