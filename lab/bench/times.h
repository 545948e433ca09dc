#pragma once

#include <algorithm>
#include <vector>

#include "app/json_output.h"

namespace mien::lab {

/// Of how long something took each time (seconds, not empty): the median and the slowest, milliseconds.
[[nodiscard]] inline app::Json times_ms(std::vector<double> took_s) {
  std::ranges::sort(took_s);
  return {{"median_ms", 1e3 * took_s[took_s.size() / 2]}, {"worst_ms", 1e3 * took_s.back()}};
}

}  // namespace mien::lab
