#pragma once

#include <cstdint>
#include <filesystem>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/take/take.h"

namespace mien::app {

/// Whether a take can be worn again. Errors: bad_usage (it was recorded or imported, its rig has a
/// microphone, or less than a second of it is evaluated).
[[nodiscard]] Result<void> check_wears_again(const take::Take& take);

/// Performs the evaluated part of a performed take anew, as a take in `folder`, which must be there: the same
/// face, rig, profile and prologue, but another wear of the sensors, drawn from `seed` (placement, faults,
/// and the head's motion, which truth does not hold). A take that check_wears_again() let pass. Errors: the
/// take's, virt::perform_take's.
[[nodiscard]] Result<take::Take> wear_again(const take::Take& take, std::uint64_t seed,
                                            const std::filesystem::path& folder, const Progress& progress);

}  // namespace mien::app
