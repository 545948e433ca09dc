#pragma once

#include "mien/performer/canvas.h"

namespace mien::performer {

/// As fast as faces move, for as long as the canvas lasts: bouts of a second or three with hardly a rest
/// between them. Laughter (notes every 210 ms: Provine and Yong 1991,
/// doi:10.1111/j.1439-0310.1991.tb00298.x), starts of 70 to 120 ms, poses in turn at 2 to 4.5 a second, lids
/// that flutter, and lips that meet five to seven times a second, as in "papapa".
void perform_rapid(Canvas& canvas, Random random);

}  // namespace mien::performer
