#pragma once

#include <algorithm>
#include <string_view>

#include "mien/core/progress.h"

namespace mien::solve {

/// Progress of a part of some work: what it reports as 0 to 1 is from `from` to `to` of the whole. `whole`
/// must outlive it.
[[nodiscard]] inline Progress part_of_work(const Progress& whole, double from, double to) {
  return [&whole, from, to](double part, std::string_view what) {
    return whole(from + (to - from) * std::clamp(part, 0.0, 1.0), what);
  };
}

}  // namespace mien::solve
