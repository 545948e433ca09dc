#pragma once

#include <chrono>

#include "mien/core/time.h"

namespace mien::lab {

/// What benchmarks measure with.
using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_since(Clock::time_point from) {
  return to_seconds(Clock::now() - from);
}

}  // namespace mien::lab
