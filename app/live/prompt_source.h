#pragma once

#include <string>
#include <vector>

#include "mien/core/error.h"
#include "mien/live/dataset_shelf.h"
#include "mien/session/prompt_script.h"

namespace mien::app {

/// The poses that `mien record --prompts WHAT` asks for: a file of them; the name of a shipped one
/// ("one_minute"); or "components:N[:SEED]", N poses drawn as the published eyewear study draws its own: six
/// components of a moving face, each at its least, its origin or its most. The same seed (1 unless given)
/// draws the same. Errors: the file's; not_found (no such script); bad_usage (no number). Cost of drawing:
/// some seconds.
[[nodiscard]] Result<session::PromptScript> load_prompts(const std::string& what);

/// What a page may have performers read and do for a dataset: these files, and those of prompts/ whose
/// prompts belong to blocks. Of one name the first counts. Errors: the files'; malformed (no prompt of one of
/// `own` belongs to a block).
[[nodiscard]] Result<std::vector<live::RecordingScript>> recording_scripts(
    const std::vector<std::string>& own);

}  // namespace mien::app
