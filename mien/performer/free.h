#pragma once

#include "mien/performer/canvas.h"

namespace mien::performer {

/// Fills the canvas with random motion of all shapes: a broad training prior over combinations and speeds.
/// Regimes of 3 to 12 seconds follow each other, each with random sparse combinations of shapes, strength and
/// speed: single bumps of 0.08 to 2 s, smooth low-rank processes, steps from pose to pose with holds, and
/// motion at syllable rate.
void perform_free(Canvas& canvas, Random random);

}  // namespace mien::performer
