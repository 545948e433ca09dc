#pragma once

#include "mien/performer/canvas.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// A meal, for as long as the canvas lasts: mouthfuls and sips in turn, each mouthful chewed and swallowed.
///
/// The jaw goes round at the person's own pace, 1 to 2.1 cycles a second (mean 1.57, 5th and 95th percentile
/// 0.94 and 2.17: Po et al. 2011, doi:10.1177/0022034511416669), behind closed lips: down, and back up on the
/// side that chews, less far as the food gets softer. For a mouthful head and eyes go down to the hand; for a
/// cup the head leans back by 8 to 25 degrees while the lips hold its rim. Hand and cup hide the face from a
/// camera; they touch no sensor here.
void perform_eating(Canvas& canvas, const Style& style, const Random& random);

}  // namespace mien::performer
