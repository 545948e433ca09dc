#pragma once

#include "mien/performer/canvas.h"
#include "mien/performer/style.h"

namespace mien::performer {

/// Fills the canvas with a meal: mouthfuls, chewed and swallowed, and sips in turn.
///
/// The jaw cycles at the person's own pace, 1 to 2.1 times a second (mean 1.57, 5th and 95th percentile 0.94
/// and 2.17: Po et al. 2011, doi:10.1177/0022034511416669), behind closed lips: down, and up on the chewing
/// side, less far as the food softens. For a mouthful head and eyes turn down to the hand; for a cup the head
/// leans back by 8 to 25 degrees while the lips hold its rim. Hand and cup touch no sensor.
void perform_eating(Canvas& canvas, const Style& style, const Random& random);

}  // namespace mien::performer
