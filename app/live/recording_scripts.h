#pragma once

#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/dataset_shelf.h"

namespace mien::app {

/// What a page may have performers read and do for a dataset: these files, and those of prompts/ whose
/// prompts belong to blocks. Of one name the first counts. Errors: the files'; malformed (no prompt of one of
/// `own` belongs to a block).
[[nodiscard]] Result<std::vector<live::RecordingScript>> recording_scripts(
    const std::vector<std::string>& own);

}  // namespace mien::app
