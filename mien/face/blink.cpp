#include "mien/face/blink.h"

#include <algorithm>

namespace mien::face {

namespace {
constexpr double kPartialShare = 0.2;
}

Blink draw_blink(double begin_s, Random& random) {
  Blink blink;
  blink.begin_s = begin_s;
  blink.closing_s = random.uniform(0.08, 0.10);
  blink.hold_s = std::min(0.12, random.exponential(0.02));
  blink.opening_s = random.uniform(0.15, 0.20);
  blink.peak = random.chance(kPartialShare) ? random.uniform(0.3, 0.75) : random.uniform(0.92, 1.0);
  blink.right_lag_s = random.normal(0, 0.004);
  return blink;
}

}  // namespace mien::face
