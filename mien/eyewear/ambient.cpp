#include "mien/eyewear/ambient.h"

namespace mien::eyewear {

double AmbientFilter::add(const sensor::Sample& sample) {
  if (newest_) {
    const Duration step = sample.time - *newest_;
    if (step > kForget || step < -kForget)
      reset();
    else if (step <= Duration::zero())
      return median_.median();
  }
  newest_ = sample.time;
  return median_.add(static_cast<double>(sample.values[0]) - static_cast<double>(sample.values[1]));
}

void AmbientFilter::reset() {
  median_.reset();
  newest_.reset();
}

}  // namespace mien::eyewear
