#pragma once

#include <cstdint>
#include <vector>

#include "lab/motion_statistics.h"
#include "mien/core/error.h"
#include "mien/core/progress.h"

namespace mien::lab {

struct VirtualMotionRequest {
  int performers = 20;   ///< People drawn, each of whom performs every kind of script.
  double seconds = 120;  ///< Of each performance.
  std::uint64_t seed = 1;
  unsigned threads = 0;  ///< 0: one a core.
};

/// How virtual performers move: for each kind of script from range of motion to acted lines the mean of the
/// people's own statistics (mean_statistics), named after the kind. The same request gives the same numbers,
/// whatever the number of threads. Errors: bad_usage (nobody, or less than a second); cancelled. Cost: a
/// hundredth of what is performed.
[[nodiscard]] Result<std::vector<MotionStatistics>> virtual_motion(const VirtualMotionRequest& request,
                                                                   const Progress& progress);

}  // namespace mien::lab
