#pragma once

#include "mien/core/random.h"
#include "mien/face/motion.h"
#include "mien/performer/script.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// Simulates a script in a person's style: frames on the 60 Hz grid, frame i at frame_offset(i), round(60 x
/// duration) of them, at least one. Weights within [0, 1.1], mouthClose <= jawOpen in every frame. The same
/// script, style and random state give the same bits. Thread-safe. Cost: well under 1/300 of real time. How
/// it works, and how it compares with real performances: docs/method/performer.md.
[[nodiscard]] face::Motion perform(const Script& script, const Style& style, const Random& random);

}  // namespace mien::performer
