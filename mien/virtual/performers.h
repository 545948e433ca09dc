#pragma once

#include <cstddef>
#include <functional>

#include "mien/core/error.h"
#include "mien/core/progress.h"

namespace mien::virt {

/// Calls `perform` for 0, 1, ... count - 1, side by side in `threads` threads (0: one a core), and waits for
/// all. The first error stops the rest; so does `progress`. Errors: perform's; cancelled.
[[nodiscard]] Result<void> for_each_performer(std::size_t count, unsigned threads, const Progress& progress,
                                              const std::function<Result<void>(std::size_t)>& perform);

}  // namespace mien::virt
