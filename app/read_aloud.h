#pragma once

#include <span>

#include "mien/core/error.h"
#include "mien/core/progress.h"
#include "mien/core/wav.h"
#include "mien/performer/script.h"

namespace mien::app {

/// Sets a line into what is heard, at its place, cut at `end_s`. What is heard gets the line's rate where it
/// has none.
void mix(const Sound& line, double at_s, double end_s, Sound& all);

/// Has every reading or acted segment of scripts that follow one another say lines of ours, in English,
/// German, Spanish or French, by espeak-ng: the segment's utterance gets its phonemes and their times, and
/// the result is what is heard, from the first script's start. Errors: bad_usage (nothing in them is said);
/// not_found (no mien-media); what the helper says; cancelled.
[[nodiscard]] Result<Sound> read_aloud(std::span<performer::Script> scripts, const Progress& progress);

}  // namespace mien::app
