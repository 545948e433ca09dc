#include "mien/core/streaming_mode.h"

#include <algorithm>
#include <cmath>

namespace mien {
namespace {

constexpr std::size_t kPad = 2;
constexpr double kLastBin = static_cast<double>(StreamingMode::kBins - 1);

}  // namespace

void StreamingMode::add(float value) {
  if (!std::isfinite(value)) return;
  const auto bin = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0F, 1.0F) * kLastBin));
  if (count_ == kWindow)
    --counts_[kPad + ring_[next_]];
  else
    ++count_;
  ++counts_[kPad + bin];
  ring_[next_] = bin;
  next_ = static_cast<std::uint16_t>((next_ + 1U) % kWindow);
}

int StreamingMode::smoothed(int bin) const {
  const auto at = static_cast<std::size_t>(bin + static_cast<int>(kPad));
  return counts_[at - 1] + 2 * counts_[at] + counts_[at + 1];
}

double StreamingMode::mode() const {
  if (count_ == 0) return 0;
  int best = 0;
  int height = 0;
  for (int bin = 0; bin < static_cast<int>(kBins); ++bin) {
    const int here = smoothed(bin);
    if (here > height) {
      best = bin;
      height = here;
    }
  }
  if (best == 0) return 0;
  if (best == static_cast<int>(kBins) - 1) return 1;
  const int below = smoothed(best - 1);  // Less than `height`: the parabola opens downwards.
  const int above = smoothed(best + 1);
  const double offset = 0.5 * (below - above) / (below - 2 * height + above);
  return (best + offset) / kLastBin;
}

double StreamingMode::upper(double share) const {
  if (count_ == 0) return 0;
  double left = share * count_;
  for (std::size_t bin = kBins; bin-- > 0;) {
    const double here = counts_[kPad + bin];
    if (here > 0 && here >= left)
      return std::clamp((static_cast<double>(bin) + 0.5 - left / here) / kLastBin, 0.0, 1.0);
    left -= here;
  }
  return 0;
}

void StreamingMode::reset() {
  counts_.fill(0);
  count_ = 0;
  next_ = 0;
}

}  // namespace mien
