#pragma once

#include "mien/performer/canvas.h"

namespace mien::performer {

/// Crude random motion of all shapes, nothing that a person would do on purpose: the broad prior under which
/// a model meets every combination and speed. Regimes of 3 to 12 seconds follow each other, each with its own
/// combinations of shapes (sparse, drawn anew), strength and speed: single bumps of 0.08 to 2 s, smooth
/// processes of low rank, jumps from pose to pose with holds, and chatter at the rate of syllables.
void perform_free(Canvas& canvas, Random random);

}  // namespace mien::performer
