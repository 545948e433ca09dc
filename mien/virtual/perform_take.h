#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/virtual/stage.h"

namespace mien::virt {

/// What `mien perform --take` is asked for.
struct PerformRequest : StageRequest {
  std::filesystem::path take;
  bool replace = false;
  bool real_time = false;  ///< Write the take at the pace of its packets' arrivals.
  std::string software;    ///< Goes into the take's header.
};

/// What was written.
struct PerformSummary {
  double duration_s = 0;
  std::size_t frames = 0;
  std::size_t packets = 0;
  std::size_t samples = 0;
};

/// Whether the take may be written, to be asked before long work. Errors: bad_usage (it exists, and is not to
/// be replaced).
[[nodiscard]] Result<void> check_take_is_new(const PerformRequest& request);

/// Performs into a take. A cancelled or failed run at full speed leaves no file; at real pace the take stays
/// as far as it came. Errors: those of the readers; bad_usage (the take exists); out_of_range (too long); io;
/// cancelled.
[[nodiscard]] Result<PerformSummary> perform_take(const PerformRequest& request, const Progress& progress);

}  // namespace mien::virt
