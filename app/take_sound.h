#pragma once

#include "mien/core/error.h"
#include "mien/core/wav.h"
#include "mien/take/take.h"

namespace mien::app {

/// What is heard in a take: the blocks that its session logged, of the device that was heard first, or else
/// the sound that was recorded beside it. Blocks that were lost are silence; where a device restarts, or is
/// not heard for a minute, its next block follows at once. Errors: not_found (no sound), the take's.
[[nodiscard]] Result<Sound> sound_of(const take::Take& take);

}  // namespace mien::app
