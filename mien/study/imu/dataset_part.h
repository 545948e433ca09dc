#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "mien/core/error.h"
#include "mien/study/dataset.h"
#include "mien/study/imu/make_dataset.h"

namespace mien::study {

/// The same performances as fewer sensors saw them, in the order of `names`. Errors: not_found (a name that
/// is none of the data set's), bad_usage (none is named).
[[nodiscard]] Result<Dataset> with_sensors(const Dataset& data, std::span<const std::string> names);

/// The performances of one in `one_in` people: of those whose number leaves the remainder `which` (held to
/// below `one_in`). `one_in`: 1 or more.
[[nodiscard]] Dataset one_in_people(const Dataset& data, std::size_t one_in, std::size_t which);

/// What virtual performers gave and what takes gave, in one. People get numbers that no performer has; the
/// standard skin is the performers'. Errors: mismatch (other sensors).
[[nodiscard]] Result<TrainingData> put_together(TrainingData performed, TrainingData takes);

}  // namespace mien::study
