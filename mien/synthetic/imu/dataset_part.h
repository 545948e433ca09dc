#pragma once

#include <cstddef>

#include "mien/core/error.h"
#include "mien/dataset/dataset.h"
#include "mien/synthetic/imu/make_dataset.h"

namespace mien::synthetic {

/// The performances of one in `one_in` people: of those whose number leaves the remainder `which` (held to
/// below `one_in`). `one_in`: 1 or more.
[[nodiscard]] dataset::Dataset one_in_people(const dataset::Dataset& data, std::size_t one_in,
                                             std::size_t which);

/// What virtual performers gave and what takes gave, in one. People get numbers that no performer has; the
/// standard skin is the performers'. Errors: mismatch (other sensors).
[[nodiscard]] Result<dataset::TrainingData> put_together(dataset::TrainingData performed,
                                                         dataset::TrainingData takes);

}  // namespace mien::synthetic
