#pragma once

#include "mien/performer/canvas.h"

namespace mien::performer {

/// Fills the canvas with the fastest motions of faces: bouts of one to three seconds, nearly without rest.
/// Laughter (notes every 210 ms: Provine and Yong 1991, doi:10.1111/j.1439-0310.1991.tb00298.x), onsets of 70
/// to 120 ms, alternating poses at 2 to 4.5 a second, fluttering lids, and lips that meet five to seven times
/// a second ("papapa").
void perform_rapid(Canvas& canvas, Random random);

}  // namespace mien::performer
