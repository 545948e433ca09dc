#include "mien/shaping/blink_peaks.h"

#include <algorithm>

namespace mien::shaping {
namespace {

/// Beyond noise and most lids that follow the eyes down; below half of a blink that reads 0.4 above rest.
constexpr float kBegins = 0.15F;
constexpr float kEnds = 0.5F * kBegins;

}  // namespace

void BlinkPeaks::add(float weight, float rest) {
  if (weight < rest + kEnds) {
    if (closing_) {
      peaks_.at(next_) = peak_;
      next_ = (next_ + 1) % kKept;
      count_ = std::min(count_ + 1, kKept);
    }
    closing_ = false;
    seen_open_ = true;
  } else if (closing_) {
    peak_ = std::max(peak_, weight);
  } else if (seen_open_ && weight > rest + kBegins) {
    closing_ = true;
    peak_ = weight;
  }
}

void BlinkPeaks::lose() {
  closing_ = false;
  seen_open_ = false;
}

std::optional<float> BlinkPeaks::largest() const {
  if (count_ < kLeast) return std::nullopt;
  return *std::max_element(peaks_.begin(), peaks_.begin() + static_cast<std::ptrdiff_t>(count_));
}

}  // namespace mien::shaping
